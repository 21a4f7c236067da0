"""The chain of stages: one ping in, its detections out."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ods.messages import SAMPLE_DTYPES, Detection, Detections, Ping, frame_of
from ods.pipeline import detect, equalize, median, smooth  # noqa: F401  they register the stages that come with ODS
from ods.pipeline.amplitude import to_amplitude
from ods.pipeline.echoes import FIELDS, measure_echoes
from ods.pipeline.fan import Fan
from ods.pipeline.kernel import kernel
from ods.pipeline.params import StageError, read_params, stage_label
from ods.pipeline.plan import PingError, Plan, geometry_key, make_plan
from ods.pipeline.regions import paint
from ods.pipeline.registry import DetectStep, ImageStep, Stage, find_stage, load_plugins, reason
from ods.pipeline.settings import PipelineSettings
from ods.settings import Settings

Mask = NDArray[np.int32]
"""(beams, samples) number of the detection that a cell belongs to, from 1; 0 for the background."""


_CELLS = FIELDS.index("cells")


class Chain:
    """Turns pings into detections by the configured stages. Keeps buffers and prepared stages for the geometry of the
    last ping, so that a stream of like pings costs no more than the work on their samples."""

    def __init__(self, settings: PipelineSettings) -> None:
        """Find the stages and check their parameters. Raises StageError."""
        load_plugins(settings.plugins)
        self._settings = settings
        self._stages = _configured(settings)
        self._key: tuple[Any, ...] = ()
        self._plan: Plan
        self._planes: list[_Plane] = []

    def process(self, ping: Ping, mask: Mask | None = None) -> Detections:
        """Return the detections of one ping; mark their cells in `mask`, (beams, samples) of zeros, when given.

        Raises PingError for a ping that makes no sense, StageError for a stage that fails.
        """
        frame = _checked_frame(ping)
        self._prepare(ping)
        usable = _shows_something(frame[:, self._plan.first :])
        found: list[Detection] = []
        if usable:
            rows = 0
            for plane in self._planes:
                stop = rows + plane.fan.shape[0]
                part = None if mask is None else mask[rows:stop, self._plan.first :]
                found += plane.detect(frame[rows:stop], ping, self._plan, part, len(found))
                rows = stop
        return Detections(
            seq=ping.seq,
            ping_number=ping.ping_number,
            t_ns=ping.t_ns,
            t_rx_ns=ping.t_rx_ns,
            utc_ns=ping.utc_ns,
            sound_speed=ping.sound_speed,
            sector=self._plan.sector,
            detections=found,
            usable=usable,
        )

    def _prepare(self, ping: Ping) -> None:
        key = geometry_key(ping)
        if key != self._key:
            plan = make_plan(ping, self._settings)
            planes = [_Plane(fan, self._stages) for fan in plan.fans]
            self._key, self._plan, self._planes = key, plan, planes  # all or, when one fails, none


class _Plane:
    """The stages prepared for one plane of beams, and their buffers."""

    def __init__(self, fan: Fan, stages: list[tuple[str, Stage, Settings]]) -> None:
        self.fan = fan
        self._image = np.empty(fan.shape, np.float32)
        self._spare = np.empty(fan.shape, np.float32)
        steps = []
        for label, stage, params in stages:
            with _blaming(label):
                steps.append((label, stage.prepare(params, fan)))
        self._filters: list[tuple[str, ImageStep]] = steps[:-1]
        self._detect: tuple[str, DetectStep] = steps[-1]

    def detect(
        self, frame: NDArray[np.generic], ping: Ping, plan: Plan, mask: Mask | None, number: int
    ) -> list[Detection]:
        """Return the detections of this plane's rows of the frame; they are numbered after the first `number`."""
        source, out = self._image, self._spare
        to_amplitude(frame, plan.first, ping.scale, ping.scale_factor, plan.table, source)
        for label, filter_step in self._filters:
            with _blaming(label):
                filter_step(source, out)
            source, out = out, source
        label, detect_step = self._detect
        with _blaming(label):
            regions = detect_step(source)
        table = measure_echoes(source, frame, plan.first, regions, self.fan)
        if mask is not None:
            paint(regions.runs, number, mask)
        return [_detection(row, self.fan.elevation_rad) for row in table.tolist()]


@contextmanager
def _blaming(label: str) -> Iterator[None]:
    """Turn whatever a stage raises, which may be anybody's code, into a StageError that names the stage."""
    try:
        yield
    except Exception as error:
        raise StageError(f"{label}: {reason(error)}") from error


def _detection(row: list[float], elevation_rad: float) -> Detection:
    before, (cells, *after) = row[:_CELLS], row[_CELLS:]
    return Detection(*before, int(cells), *after, elevation_rad)  # type: ignore[call-arg, arg-type]


def _configured(settings: PipelineSettings) -> list[tuple[str, Stage, Settings]]:
    """Return (label, stage, parameters) of the whole chain. Raises StageError."""
    stages = []
    for index, entry in enumerate(settings.chain()):
        label = f"pipeline.{stage_label(index, entry)}"
        try:
            stage = find_stage(entry["use"])
            stages.append((label, stage, read_params(stage.params, entry)))
        except StageError as error:
            raise StageError(f"{label}: {error}") from error
    if [stage.kind for _, stage, _ in stages] != ["image"] * (len(stages) - 1) + ["detect"]:
        raise StageError("pipeline.stage: the last stage, and no other, must be one that detects")
    return stages


def _checked_frame(ping: Ping) -> NDArray[np.generic]:
    try:
        frame = frame_of(ping)
    except ValueError as error:
        raise PingError(str(error)) from error
    if frame.dtype == SAMPLE_DTYPES["f4"] and not np.isfinite(frame).all():
        raise PingError("samples are not finite")
    return frame


@kernel
def _shows_something(frame: NDArray[np.generic]) -> bool:
    """Tell an image from a drop-out, in which all samples are alike."""
    for b in range(frame.shape[0]):
        row = frame[b]
        for j in range(row.size):
            if row[j] != frame[0, 0]:
                return True
    return False
