"""Stages by name: how a stage is declared, found and given its parameters.

A stage is a function `prepare(params, fan)` that is called once for each fan geometry and returns the step that is then
called for each image. What a step needs only once (coefficients, buffers) is made in `prepare`.

    class Params(Settings, frozen=True):
        exponent: Positive = 2.0

    @image_stage("my.power", Params)
    def power(params: Params, fan: Fan) -> ImageStep:
        def step(source: Image, out: Image) -> None:
            np.power(source, params.exponent, out=out)
        return step

A stage outside this package is found by an entry point of the group `ods.stages` that names its module, or by a file
named in `[pipeline] plugins`.
"""

import importlib.metadata
import importlib.util
import sys
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

from ods.base.choices import none_of
from ods.base.errors import one_line
from ods.base.settings import Settings
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.params import ENTRY_POINT_GROUP, StageError
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


_stages: dict[str, Stage] = {}


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
        _register(Stage(name, kind, params, prepare))
        return prepare

    return register


def _register(stage: Stage) -> None:
    known = _stages.get(stage.name)
    if known and known.prepare is not stage.prepare:
        where = f"{known.prepare.__module__}.{known.prepare.__qualname__}"
        raise StageError(f"stage {stage.name}: the name is already taken by {where}")
    _stages[stage.name] = stage


def stage_names() -> list[str]:
    """Return the names of all stages known now, sorted."""
    return sorted(_stages)


def find_stage(name: str) -> Stage:
    """Return a stage by its name. Raises StageError, which lists the names that are known."""
    if name not in _stages:
        raise StageError(f"use: {none_of(name, stage_names())}")
    return _stages[name]


def load_plugins(files: Iterable[Path]) -> None:
    """Run the user's files and the modules of the entry points, which register their stages. Raises StageError."""
    for entry in importlib.metadata.entry_points(group=ENTRY_POINT_GROUP):
        try:
            entry.load()
        except Exception as error:
            raise StageError(f"entry point {ENTRY_POINT_GROUP} {entry.name}: {reason(error)}") from error
    for index, file in enumerate(files):
        try:
            _run_file(file.resolve())
        except Exception as error:
            raise StageError(f"pipeline.plugins[{index}] ({file}): {reason(error)}") from error


def _run_file(file: Path) -> None:
    """Import a file as a module of its own, once a process."""
    name = f"ods_plugin:{file}"
    if name in sys.modules:
        return
    spec = importlib.util.spec_from_file_location(name, file)
    if spec is None or spec.loader is None:
        raise ImportError("not a Python file")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # before it runs: dataclasses and typing look their module up
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise


def reason(error: Exception) -> str:
    """Say in one line what went wrong in somebody else's code."""
    text = one_line(error)
    return text if isinstance(error, StageError) else f"{type(error).__name__}: {text}"
