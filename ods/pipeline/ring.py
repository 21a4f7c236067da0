"""The chain of stages on one plane of beams, or on a part of its ranges."""

import numpy as np
from numpy.typing import NDArray

from ods.messages import Detection, Ping
from ods.pipeline.amplitude import HALF_COUNT, Frame, Table, average_columns, to_amplitude
from ods.pipeline.echoes import FIELDS, measure_echoes
from ods.pipeline.fan import Image
from ods.pipeline.params import GroupParams, StageError
from ods.pipeline.pings import Look, PingStep
from ods.pipeline.plan import Part
from ods.pipeline.regions import Regions, paint
from ods.pipeline.registry import DetectStep, ImageStep, Stage, reason
from ods.pipeline.samples import GainStep, Samples, SamplesStep, samples_of, write_image
from ods.settings import Settings

Mask = NDArray[np.int32]
"""(beams, samples) number of the detection that a cell belongs to, from 1; 0 for the background."""

_CELLS = FIELDS.index("cells")
_AMPLITUDE = FIELDS.index("amplitude")
_LOOKED_AT = 4096
"""Samples of a frame that its strongest share is measured on."""


class Ring:
    """The stages prepared for one plane of beams, or for a part of its ranges, and their buffers."""

    def __init__(self, part: Part, stages: list[tuple[str, Stage, Settings]]) -> None:
        """Prepare the stages. Raises StageError."""
        fan = part.fan
        self.part = part
        params = stages[-1][2]
        self._strongest = params.strongest if isinstance(params, GroupParams) else 1.0
        self._images = (np.empty(fan.shape, np.float32), np.empty(fan.shape, np.float32))
        self._whole = tuple(samples_of(image) for image in self._images)
        beams, samples = fan.shape
        self._fine = np.empty((beams, samples * part.stride if part.stride > 1 else 0), np.float32)
        steps = []
        for label, stage, params in stages:
            try:
                steps.append((label, stage.prepare(params, fan)))
            except Exception as error:
                raise _blamed(label, error) from error
        self._filters: list[tuple[str, ImageStep]] = steps[:-1]
        self._detect: tuple[str, DetectStep] = steps[-1]
        self._ping_steps = [step for _, step in self._filters if isinstance(step, PingStep)]

    def detect(
        self, frame: Frame, ping: Ping, table: Table | None, look: Look, mask: Mask | None, number: int
    ) -> list[Detection]:
        """Return the detections of this part of the frame; they are numbered after the first `number`.

        frame, mask: (all beams, all samples); table: of `amplitude_table`.
        """
        part = self.part
        rows = frame[part.rows]
        for step in self._ping_steps:
            step.look = look
        image = self._filtered(rows, ping, table)
        label, detect_step = self._detect
        try:
            regions = detect_step(image)
        except Exception as error:
            raise _blamed(label, error) from error
        echoes = measure_echoes(image, rows, part.first, part.stride, regions, part.fan)
        if self._strongest < 1.0:
            regions, echoes = _selected(regions, echoes, echoes[:, _AMPLITUDE] >= _level_of(rows, self._strongest))
        if part.partial:
            regions, echoes = _selected(regions, echoes, _answered_for(echoes, part))
        if mask is not None:
            paint(regions.runs, number, mask[part.rows, part.first :], part.stride)
        return [_detection(row, part.fan.elevation_rad) for row in echoes.tolist()]

    def _filtered(self, frame: Frame, ping: Ping, table: Table | None) -> Image:
        """Return the image after all stages but the last."""
        samples = self._recorded(frame, ping, table)
        for label, step in self._filters:
            try:
                samples = self._apply(step, samples)
            except Exception as error:
                raise _blamed(label, error) from error
        return self._images[self._as_image(samples)]

    def _recorded(self, frame: Frame, ping: Ping, table: Table | None) -> Samples:
        """Return the samples as the first stage gets them: linear counts as they are, all others as amplitudes."""
        part, whole, image = self.part, self._whole[0], self._images[0]
        if part.stride == 1 and ping.scale == "linear" and frame.dtype.kind == "u":
            return whole._replace(cells=frame, first=part.first, offset=HALF_COUNT)
        if part.stride == 1:
            to_amplitude(frame, part.first, ping.scale, ping.scale_factor, table, image)
        else:
            to_amplitude(frame, part.first, ping.scale, ping.scale_factor, table, self._fine)
            average_columns(self._fine, part.stride, image)
        return whole

    def _apply(self, step: ImageStep, samples: Samples) -> Samples:
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

    def _other(self, samples: Samples) -> int:
        """Return the number of the buffer that these samples do not lie in."""
        return int(samples.cells is self._images[0])

    def _as_image(self, samples: Samples) -> int:
        """Return the number of the buffer that holds samples, of gain 1: written there, unless they are so already."""
        out = self._other(samples)
        if samples.plain and samples.cells is self._images[1 - out]:
            return 1 - out
        write_image(*samples.args, self._images[out])
        return out


def _blamed(label: str, error: Exception) -> StageError:
    """Return the complaint about whatever a stage raised, which may be anybody's code."""
    return StageError(f"{label}: {reason(error)}")


def _level_of(frame: Frame, strongest: float) -> float:
    """Return the recorded level that the share `strongest` of the samples of frame (beams, samples) reaches.

    Looked at are some of them, evenly spread, in steps that never fall in with the rows.
    """
    cells = frame.reshape(-1) if frame.flags.c_contiguous else frame.ravel()
    some = np.sort(cells[:: max(1, cells.size // _LOOKED_AT) | 1])
    return float(some[min(int((1.0 - strongest) * some.size), some.size - 1)])


def _answered_for(echoes: NDArray[np.float64], part: Part) -> NDArray[np.bool_]:
    """Tell the echoes whose centre this part answers for; those in its margins are the neighbour's."""
    return (echoes[:, 0] >= part.from_m) & (echoes[:, 0] < part.to_m)


def _selected(
    regions: Regions, echoes: NDArray[np.float64], chosen: NDArray[np.bool_]
) -> tuple[Regions, NDArray[np.float64]]:
    """Return the chosen regions, numbered anew without a gap, and their echoes."""
    kept = np.flatnonzero(chosen)
    if len(kept) == regions.total:
        return regions, echoes
    number = np.zeros(regions.total + 1, np.int32)
    number[kept + 1] = np.arange(1, len(kept) + 1)
    runs = regions.runs.copy()
    runs[:, 3] = number[runs[:, 3]]
    return Regions(runs[runs[:, 3] > 0], len(kept), regions.background), echoes[kept]


def _detection(row: list[float], elevation_rad: float) -> Detection:
    before, (cells, *after) = row[:_CELLS], row[_CELLS:]
    return Detection(*before, int(cells), *after, elevation_rad)  # type: ignore[call-arg, arg-type]
