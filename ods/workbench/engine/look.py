"""One stage's image of a ping as it is looked at: the whole fan, in decibels, with what was not processed left out."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Floats32, Image, Ints
from ods.messages import Ping
from ods.pipeline.stage.watch import StageImage

FAINTEST = 1e-3
"""Amplitudes below this part of the median are shown as this."""
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
    image: Image
    """(beams, samples) amplitude; NaN where nothing was processed. Of several planes the highest."""
    levels: tuple[float, float] | None = None
    """Low and high level, amplitude, that the detector compared with this image."""

    @cached_property
    def unit(self) -> float:
        """The median, which is 0 dB."""
        step = max(1, self.image.size // SAMPLED_CELLS)
        cells = self.image.ravel()[:: step | 1]  # odd: another column in each beam
        cells = cells[cells > 0.0]
        return float(np.median(cells)) if cells.size else 1.0

    def level_db(self, beams: slice = slice(None)) -> Floats32:
        """Return the levels of some beams, (beams, samples), over the median; NaN where nothing was processed."""
        scaled = self.image[beams] * np.float32(1.0 / self.unit)
        np.maximum(scaled, np.float32(FAINTEST), out=scaled)
        np.log10(scaled, out=scaled)
        return np.asarray(np.multiply(scaled, np.float32(20.0), out=scaled), np.float32)

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
    place = look.level_db()
    place -= np.float32(LOWEST_DB)
    place *= np.float32(BINS / (HIGHEST_DB - LOWEST_DB))
    np.clip(place, 0.0, BINS - 1, out=place)
    place[np.isnan(place)] = BINS
    return Histogram(edges, np.bincount(place.astype(np.uint8).ravel(), minlength=BINS)[:BINS])


def profile(look: Look, beam: int) -> Floats32:
    """Return the levels along one beam, (samples,) dB over the image's median. Raises IndexError."""
    return np.asarray(look.level_db(slice(beam, beam + 1))[0])


def grid_of(ping: Ping) -> Grid:
    """Return where a ping's cells lie."""
    beams = ping.beams // ping.planes
    return Grid(np.array(ping.bearing_rad[:beams]), ping.range0_m, ping.dr_m, ping.samples)


def looks_of(grid: Grid, shown: Sequence[StageImage], labels: Sequence[str]) -> list[Look]:
    """Return what each of the stages `labels` made, from what `Chain` showed: plane by plane, ring by ring.

    A detector that shows nothing has the image of the stage before it.
    """
    rows: list[list[StageImage]] = []
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


def _joined(grid: Grid, images: Sequence[StageImage]) -> Image:
    """Return the images of all planes and rings of one stage as one, (beams, samples) of the grid."""
    shape = len(grid.bearing_rad), grid.samples
    if len(images) == 1 and images[0].image.shape == shape:
        return images[0].image
    whole = np.full(shape, np.nan, np.float32)
    for number, each in enumerate(images):
        stride = max(1, round(each.fan.dr_m / grid.dr_m))
        first = np.rint((each.fan.range_m - grid.range0_m) / grid.dr_m - 0.5 * (stride - 1)).astype(np.int64)
        for k in range(stride):
            inside = first + k < grid.samples
            columns = _slice_of((first + k)[inside])
            part = each.image if inside.all() else each.image[:, inside]
            whole[:, columns] = np.fmax(whole[:, columns], part) if number else part
    return whole


def _slice_of(places: Ints) -> Ints | slice:
    """Return rising places as a slice, if none is left out between them: numpy copies that far faster."""
    if len(places) and places[-1] - places[0] == len(places) - 1:
        return slice(int(places[0]), int(places[-1]) + 1)
    return places
