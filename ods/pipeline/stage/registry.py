"""Stages by name: how a stage is declared.

A stage is a function `prepare(params, fan)` that is called once for each fan geometry and returns the step that is then
called for each image. What a step needs only once (coefficients, buffers) is made in `prepare`.

    class Params(Settings, frozen=True):
        exponent: Positive = 2.0

    @image_stage("my.power", Params)
    def power(params: Params, fan: Fan) -> ImageStep:
        def step(source: Image, out: Image) -> None:
            np.power(source, params.exponent, out=out)
        return step

A stage outside this package is a plug-in: named by `pipeline.plugins`, or by an entry point of the group `ods.stages`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from ods.base.plugins import add
from ods.base.settings import Settings
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.step import (
    GainedImageStep,
    GainStep,
    ImageStep,
    PingStep,
    PreparedDetector,
    StageKind,
)

ParamsT = TypeVar("ParamsT", bound=Settings)
StepT = TypeVar("StepT")
Prepare = Callable[[ParamsT, Fan], StepT]
Register = Callable[[Prepare[ParamsT, StepT]], Prepare[ParamsT, StepT]]


@dataclass(frozen=True)
class Stage:
    """One registered stage."""

    name: str
    kind: StageKind
    params: type[Settings]
    prepare: Callable[[Any, Fan], Any]
    """Returns a step of that kind, or a `PreparedDetector`."""

    @property
    def made_by(self) -> Callable[[Any, Fan], Any]:
        """Whose name it is."""
        return self.prepare


REGISTERED: dict[str, Stage] = {}
"""All that are known now; `stage.configured` finds them."""


def image_stage(name: str, params: type[ParamsT]) -> Register[ParamsT, ImageStep]:
    """Register the decorated function as a stage that turns an image into an image (equalizers, filters)."""
    return _registers(name, "image", params)


def ping_stage(name: str, params: type[ParamsT]) -> Register[ParamsT, PingStep]:
    """Register the decorated function as a stage that turns an image into an image by what earlier pings showed."""
    return _registers(name, "ping", params)


def gained_image_stage(name: str, params: type[ParamsT]) -> Register[ParamsT, GainedImageStep]:
    """Register the decorated function as a stage that turns an image into an image and applies the gain itself."""
    return _registers(name, "gained image", params)


def gain_stage(name: str, params: type[ParamsT]) -> Register[ParamsT, GainStep]:
    """Register the decorated function as a stage that changes the gain of an image, and nothing else (equalizers)."""
    return _registers(name, "gain", params)


def detect_stage(name: str, params: type[ParamsT]) -> Register[ParamsT, PreparedDetector]:
    """Register the decorated function as a stage that finds regions in an image; it ends the chain."""
    return _registers(name, "detect", params)


def _registers(name: str, kind: StageKind, params: type[ParamsT]) -> Register[ParamsT, StepT]:
    def register(prepare: Prepare[ParamsT, StepT]) -> Prepare[ParamsT, StepT]:
        add(REGISTERED, "stage", name, Stage(name, kind, params, prepare))
        return prepare

    return register
