"""One stage's image of a ping as it is looked at: the whole fan, in decibels, with what was not processed left out.

A ping leaves an image of each stage, 4 MB each at 512 x 2000 samples; so of a cell only 16 bits of its float32 are
kept, a code of which tables tell levels and colours quicker than a logarithm would.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from ods.base.arrays import Bytes, Floats, Floats32, Image, Ints, Mask
from ods.messages import Ping
from ods.pipeline.image.fan import Fan
from ods.pipeline.stage.watch import StageImage

FAINTEST = 1e-3
"""Amplitudes below this part of the median are shown as this."""
Codes = npt.NDArray[np.uint16]
"""Amplitudes as floats with eight bits of mantissa: within 0.02 dB, in order; 0: nothing was processed there."""
_CUT = 15
"""Bits of a float32 that a code goes without, beside the sign."""
_SILENT = np.float32(1e-30)
"""Amplitude that stands for 0."""
SAMPLED_CELLS = 60_000
"""Cells that tell the median."""
LOWEST_DB, HIGHEST_DB, BINS = -30.0, 60.0, 180
"""Of histograms, over the median."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Where the cells of all images of a ping lie: those of one of its planes."""

    bearing_rad: Floats
    """(beams,) rising."""
    range0_m: float
    dr_m: float
    samples: int

    @property
    def range_m(self) -> Floats:
        """Return the (samples,) slant ranges."""
        return np.asarray(self.range0_m + self.dr_m * np.arange(self.samples), np.float64)


@dataclass(frozen=True, eq=False)
class Look:
    """What one stage made of a ping."""

    label: str
    """The stage's name, or RECORDED."""
    codes: Codes
    """(beams, samples) of the amplitudes; of several planes the highest."""
    levels: tuple[float, float] | None = None
    """Low and high level, amplitude, that the detector compared with this image."""

    @cached_property
    def unit(self) -> float:
        """The median, which is 0 dB."""
        step = max(1, self.codes.size // SAMPLED_CELLS)
        cells = self.codes.ravel()[:: step | 1]  # odd: another column in each beam
        cells = cells[cells > coded(_SILENT)]
        return float(np.median(AMPLITUDES[cells])) if cells.size else 1.0

    @property
    def image(self) -> Image:
        """Return the (beams, samples) amplitudes; NaN where nothing was processed."""
        return np.asarray(AMPLITUDES[self.codes])

    @property
    def processed(self) -> Mask:
        """Return (beams, samples): where something was."""
        return np.asarray(self.codes != 0)

    def level_db(self, beams: slice = slice(None)) -> Floats32:
        """Return the levels of some beams, (beams, samples), over the median; NaN where nothing was processed."""
        return np.asarray(self._levels[self.codes[beams]])

    def through(self, law: Callable[[Floats32], Bytes]) -> Bytes:
        """Return what a law makes of each cell's level over the median, dB, NaN where nothing was processed."""
        return np.asarray(law(self._levels)[self.codes], np.uint8)

    def reading_db(self, beam: int, sample: int) -> float:
        """Return one cell's level over the median."""
        return float(self._levels[self.codes[beam, sample]])

    @property
    def _levels(self) -> Floats32:
        """By code."""
        return np.asarray(np.maximum(_DECIBELS - np.float32(20.0 * np.log10(self.unit)), _FAINTEST_DB), np.float32)

    @property
    def levels_db(self) -> tuple[float, float] | None:
        """Low and high level over the median."""
        return self.levels and (self.db_of(self.levels[0]), self.db_of(self.levels[1]))

    def db_of(self, amplitude: float) -> float:
        """Return an amplitude in dB over the median."""
        return float(20.0 * np.log10(max(amplitude / self.unit, FAINTEST)))

    def amplitude_of(self, level_db: float) -> float:
        """Return the amplitude of a level over the median."""
        return float(self.unit * 10.0 ** (level_db / 20.0))


class Histogram(NamedTuple):
    """How many cells have what level."""

    edges_db: Floats
    """(bins + 1,)."""
    cells: Ints
    """(bins,); what is lower or higher is in the first and the last one."""


def histogram(look: Look) -> Histogram:
    """Return the histogram of an image's levels."""
    edges = np.linspace(LOWEST_DB, HIGHEST_DB, BINS + 1)
    return Histogram(edges, np.bincount(look.through(_bins).ravel(), minlength=BINS)[:BINS])


def _bins(level_db: Floats32) -> Bytes:
    """Return the bin of each level; BINS for none."""
    place = np.clip((level_db - LOWEST_DB) * (BINS / (HIGHEST_DB - LOWEST_DB)), 0.0, BINS - 1)
    return np.where(np.isnan(place), BINS, place).astype(np.uint8)


def profile(look: Look, beam: int) -> Floats32:
    """Return the levels along one beam, (samples,) dB over the image's median. Raises IndexError."""
    return np.asarray(look.level_db(slice(beam, beam + 1))[0])


def grid_of(ping: Ping) -> Grid:
    """Return where a ping's cells lie."""
    beams = ping.beams // ping.planes
    return Grid(np.array(ping.bearing_rad[:beams]), ping.range0_m, ping.dr_m, ping.samples)


class Coded(NamedTuple):
    """What `Chain` showed of a stage, as it is kept."""

    label: str
    codes: Codes
    fan: Fan
    levels: tuple[float, float] | None


def of_stage(shown: StageImage) -> Coded:
    """Return what is kept of it."""
    return Coded(shown.label, coded(shown.image), shown.fan, shown.levels)


def coded(image: Image | np.float32) -> Codes:
    """Return the codes of amplitudes; of what is below zero as of zero."""
    bits = np.maximum(image, _SILENT).view(np.uint32) + np.uint32(1 << (_CUT - 1))  # rounds
    return np.asarray(bits >> np.uint32(_CUT)).astype(np.uint16)


def looks_of(grid: Grid, shown: Sequence[Coded], labels: Sequence[str]) -> list[Look]:
    """Return what each of the stages `labels` made, from what `Chain` showed: plane by plane, ring by ring.

    A detector that shows nothing has the image of the stage before it.
    """
    rows: list[list[Coded]] = []
    for each in shown:
        if each.label == labels[0]:
            rows.append([])
        rows[-1].append(each)
    for row in rows:
        if len(row) < len(labels):
            row.append(row[-1]._replace(label=labels[-1], levels=None))
    return [
        Look(label, _joined(grid, images), images[0].levels)
        for label, images in zip(labels, zip(*rows, strict=True), strict=True)
    ]


def _joined(grid: Grid, images: Sequence[Coded]) -> Codes:
    """Return the images of all planes and rings of one stage as one, (beams, samples) of the grid."""
    shape = len(grid.bearing_rad), grid.samples
    if len(images) == 1 and images[0].codes.shape == shape:
        return images[0].codes
    whole = np.zeros(shape, np.uint16)
    for number, each in enumerate(images):
        stride = max(1, round(each.fan.dr_m / grid.dr_m))
        first = np.rint((each.fan.range_m - grid.range0_m) / grid.dr_m - 0.5 * (stride - 1)).astype(np.int64)
        for k in range(stride):
            inside = first + k < grid.samples
            columns = _slice_of((first + k)[inside])
            part = each.codes if inside.all() else each.codes[:, inside]
            whole[:, columns] = np.maximum(whole[:, columns], part) if number else part
    return whole


def _slice_of(places: Ints) -> Ints | slice:
    """Return rising places as a slice, if none is left out between them: numpy copies that far faster."""
    if len(places) and places[-1] - places[0] == len(places) - 1:
        return slice(int(places[0]), int(places[-1]) + 1)
    return places


def _amplitudes() -> Floats32:
    found = (np.arange(1 << 16, dtype=np.uint32) << np.uint32(_CUT)).view(np.float32)
    found[0] = np.nan
    found[1 + int(coded(np.float32(np.inf))) :] = np.nan  # quiet ones
    return np.asarray(found)


AMPLITUDES = _amplitudes()
"""By code; NaN where nothing was processed."""
_DECIBELS = np.asarray(np.float32(20.0) * np.log10(AMPLITUDES), np.float32)
_FAINTEST_DB = np.float32(20.0 * np.log10(FAINTEST))
