"""The chain of stages on one plane of beams, or on some of its ranges."""

from collections.abc import Iterator
from itertools import compress
from typing import Any

import numpy as np

from ods.base.arrays import Image, Ints32
from ods.base.settings import Settings
from ods.messages import Detection, Ping
from ods.pipeline.detect.noise import Learner
from ods.pipeline.image.amplitude import Frame, Table, average_counts, mean_offset, to_amplitude
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.gained_image import GainedImage, GainStep, SamplesStep, samples_of, write_image
from ods.pipeline.image.regions import Regions, chosen, paint, shared_at
from ods.pipeline.measure.echoes import FIELDS, measure_echoes
from ods.pipeline.plan import ImageLayout, RangeBand
from ods.pipeline.stage.motion_compensation import PingContext, PingStep
from ods.pipeline.stage.params import GroupParams, StageError
from ods.pipeline.stage.registry import DetectStep, ImageStep, Stage, reason

Mask = Ints32
"""(beams, samples) number of the detection that a cell belongs to, from 1; 0 for the background."""

_CELLS = FIELDS.index("cells")
_AMPLITUDE = FIELDS.index("amplitude")
LEARNT_CELLS = 30_000_000
"""Cells of speckle from which a detector learns its tail, if it has to,"""
_LEARNT_IMAGES = 4
"""and the least number of images,"""
_LEARNT_STEP_NS = 100_000_000
"""so much time apart."""
_LOOKED_AT = 4096
"""Samples of a frame that its strongest share is measured on."""


class PreparedChain:
    """The stages prepared for one plane of beams, or for some of its ranges, and their buffers."""

    def __init__(self, layout: ImageLayout, stages: list[tuple[str, Stage, Settings]], learnt_cells: int) -> None:
        """Prepare the stages. Raises StageError."""
        fan = layout.fan
        self.phase = layout.phase
        self._layout = layout
        params = stages[-1][2]
        self._strongest = params.strongest if isinstance(params, GroupParams) else 1.0
        self._images = (np.empty(fan.shape, np.float32), np.empty(fan.shape, np.float32))
        self._counts: dict[np.dtype[np.generic], Frame] = {}
        self._whole = tuple(samples_of(image) for image in self._images)
        self._detect: tuple[str, DetectStep] = _prepared(stages[-1:], fan)[0]
        if isinstance(self._detect[1], Learner):
            self._use(stages[:-1])
            self._detect[1].learn(self._speckle(learnt_cells))
        self._use(stages[:-1])

    def _use(self, stages: list[tuple[str, Stage, Settings]]) -> None:
        """Prepare the stages before the last one, which may remember images, anew."""
        self._filters: list[tuple[str, ImageStep]] = _prepared(stages, self._layout.fan)
        self._ping_steps = [step for _, step in self._filters if isinstance(step, PingStep)]

    def _speckle(self, cells: int) -> Iterator[Image]:
        """Yield what the stages before the last one make of images of nothing but speckle, no two alike."""
        rng = np.random.Generator(np.random.SFC64(0))
        source = self._images[0]
        for number in range(_LEARNT_IMAGES + cells // source.size):
            for step in self._ping_steps:
                step.look = PingContext(number * _LEARNT_STEP_NS, None)
            rng.standard_exponential(out=source, dtype=np.float32)
            np.sqrt(source, out=source)
            yield self._through(self._whole[0])

    def detect(
        self, frame: Frame, ping: Ping, table: Table | None, context: PingContext, mask: Mask | None, number: int
    ) -> list[Detection]:
        """Return the detections of these rows and ranges of the frame; they are numbered after the first `number`.

        frame, mask: (all beams, all samples); table: of `amplitude_table`.
        """
        rows = frame[self._layout.rows]
        for step in self._ping_steps:
            step.look = context
        image = self._filtered(rows, ping, table)
        if self._layout.fan.seam is not None:
            image[:, self._layout.fan.seam] = 0.0  # no data: nothing reaches across
        label, detect_step = self._detect
        try:
            regions = detect_step(image)
        except Exception as error:
            raise _blamed(label, error) from error
        level = _level_of(rows, self._strongest) if self._strongest < 1.0 and regions.total else 0.0
        found: list[Detection] = []
        for part, inside in self._shared_out(regions):
            found += self._measured(image, rows, part, inside, level, mask, number + len(found))
        return found

    def _shared_out(self, regions: Regions) -> list[tuple[RangeBand, Regions]]:
        """Return the regions in the columns of each part that has any."""
        parts = self._layout.parts
        if len(parts) == 1 or not regions.total:
            return [(part, regions) for part in parts[: regions.total]]
        shares = shared_at(regions, parts[1].columns.start)
        return [(part, share) for part, share in zip(parts, shares, strict=True) if share.total]

    def _measured(
        self, image: Image, rows: Frame, part: RangeBand, regions: Regions, level: float, mask: Mask | None, number: int
    ) -> list[Detection]:
        """Return the detections of the regions in one part, those as strong as `level` that it answers for."""
        stride = self._layout.stride
        echoes = measure_echoes(image, rows, part.first, stride, regions, part.fan).tolist()
        near, far = part.from_m, part.to_m
        kept = [near <= echo[0] < far and echo[_AMPLITUDE] >= level for echo in echoes]
        if mask is not None:
            runs = chosen(regions, np.array(kept, np.bool_)).runs
            paint(runs, number, mask[self._layout.rows], part.first, stride)
        return [_detection(echo, part.fan.elevation_rad) for echo in compress(echoes, kept)]

    def _filtered(self, frame: Frame, ping: Ping, table: Table | None) -> Image:
        """Return the image after all stages but the last."""
        return self._through(self._recorded(frame, ping, table))

    def _through(self, samples: GainedImage) -> Image:
        for label, step in self._filters:
            try:
                samples = self._apply(step, samples)
            except Exception as error:
                raise _blamed(label, error) from error
        return self._images[self._as_image(samples)]

    def _recorded(self, frame: Frame, ping: Ping, table: Table | None) -> GainedImage:
        """Return the samples as the first stage gets them: linear counts as they are, all others as amplitudes."""
        stride, parts = self._layout.stride, self._layout.parts
        whole, image = self._whole[0], self._images[0]
        counts = ping.scale == "linear" and frame.dtype.kind == "u"
        if counts and stride == len(parts) == 1:
            return whole._replace(cells=frame, first=parts[0].first, offset=mean_offset(1))
        if counts:
            if frame.dtype not in self._counts:
                self._counts[frame.dtype] = np.empty(image.shape, frame.dtype)
            averaged = self._counts[frame.dtype]
            whole = whole._replace(cells=averaged, offset=mean_offset(stride))
        for part in parts:
            first, columns = part.first + stride * part.columns.start, part.columns
            if counts:
                average_counts(frame, first, stride, averaged, columns.start, columns.stop)
            else:
                to_amplitude(frame, first, stride, ping.scale, ping.scale_factor, table, image, columns)
        return whole

    def _apply(self, step: ImageStep, samples: GainedImage) -> GainedImage:
        """Return what a stage makes of samples; the image that it reads is not the one it writes."""
        if isinstance(step, GainStep):
            many = samples.gain.shape[0] > 1
            return step.regain(self._whole[self._as_image(samples)] if many else samples)
        if isinstance(step, SamplesStep):
            out = self._other(samples)
            step.run(samples, self._images[out])
        else:
            source = self._as_image(samples)
            out = 1 - source
            step(self._images[source], self._images[out])
        return self._whole[out]

    def _other(self, samples: GainedImage) -> int:
        """Return the number of the buffer that these samples do not lie in."""
        return int(samples.cells is self._images[0])

    def _as_image(self, samples: GainedImage) -> int:
        """Return the number of the buffer that holds samples, of gain 1: written there, unless they are so already."""
        out = self._other(samples)
        if samples.plain and samples.cells is self._images[1 - out]:
            return 1 - out
        write_image(*samples.args, self._images[out])
        return out


def _prepared(stages: list[tuple[str, Stage, Settings]], fan: Fan) -> list[tuple[str, Any]]:
    steps = []
    for label, stage, params in stages:
        try:
            steps.append((label, stage.prepare(params, fan)))
        except Exception as error:
            raise _blamed(label, error) from error
    return steps


def _blamed(label: str, error: Exception) -> StageError:
    """Return the complaint about whatever a stage raised, which may be anybody's code."""
    return StageError(f"{label}: {reason(error)}")


def _level_of(frame: Frame, strongest: float) -> float:
    """Return the recorded level that the share `strongest` of the samples of frame (beams, samples) reaches.

    Looked at are some of them, evenly spread, in steps that never fall in with the rows.
    """
    cells = frame.reshape(-1) if frame.flags.c_contiguous else frame.ravel()
    some = cells[:: max(1, cells.size // _LOOKED_AT) | 1]
    rank = min(int((1.0 - strongest) * some.size), some.size - 1)
    return float(np.partition(some, rank)[rank])


def _detection(row: list[float], elevation_rad: float) -> Detection:
    before, (cells, *after) = row[:_CELLS], row[_CELLS:]
    return Detection(*before, int(cells), *after, elevation_rad)  # type: ignore[call-arg, arg-type]
