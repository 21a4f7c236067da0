"""What the geometry of a ping decides once, for all pings that share it: planes, rings of attention, sector."""

import math
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.messages import SAMPLE_DTYPES, Ping, Sector
from ods.pipeline.image.amplitude import Table, amplitude_table
from ods.pipeline.image.fan import Fan, beam_borders
from ods.pipeline.settings import AttentionSettings, PipelineSettings

MAX_BEARING = math.pi
MAX_RANGE = 1e6
"""Stands for 'as far as the image reaches', m."""


class PingError(ValueError):
    """A ping cannot be processed: its tables or samples are wrong; the text says why in one line."""


EVERY_PHASE = -1


@dataclass(frozen=True, eq=False)
class RangeBand:
    """Ranges that fill some columns of an image. Places are told as if the image went on like this to both sides."""

    columns: slice
    fan: Fan
    """Where the image's cells would lie."""
    first: int
    """Samples of the frame before column 0 of the image; negative where other ranges take those columns."""
    from_m: float
    """It answers for echoes from here"""
    to_m: float
    """to here; the rest is margin."""


@dataclass(frozen=True, eq=False)
class ImageLayout:
    """What an image shows: rows and columns of the frame that are processed together."""

    fan: Fan
    rows: slice
    stride: int
    """Range samples that make one column."""
    parts: list[RangeBand]
    """One, or two rings of ranges side by side."""
    phase: int
    """The ping, modulo `Plan.phases`, at which it is processed."""


@dataclass(frozen=True, eq=False)
class Plan:
    """What all pings of one geometry have in common."""

    images: list[ImageLayout]
    phases: int
    """Pings after which all images had their turn."""
    processed_ranges_m: list[list[tuple[float, float]]]
    """For each phase, the ranges (from, to) that are processed, m; none: all."""
    first: int
    """Samples nearer than the least range."""
    sector: Sector


def geometry_key(ping: Ping) -> tuple[Any, ...]:
    """Return what a plan depends on; pings with equal keys share a plan."""
    return (
        ping.beams, ping.samples, ping.planes, ping.range0_m, ping.dr_m,
        ping.bearing_rad, ping.elevation_rad, ping.beam_width_rad,
    )  # fmt: skip


def table_for(ping: Ping) -> Table | None:
    """Return the linear amplitude of every count, where a table serves. Raises PingError."""
    if ping.scale != "linear" and not (math.isfinite(ping.scale_factor) and ping.scale_factor > 0.0):
        raise PingError(f"scale_factor: {ping.scale_factor} does not fit scale {ping.scale}")
    return amplitude_table(SAMPLE_DTYPES[ping.dtype], ping.scale, ping.scale_factor)


def make_plan(ping: Ping, settings: PipelineSettings, *, over_pings: bool = False) -> Plan:
    """Check the ping's tables and lay the plan out. Raises PingError.

    over_pings: a stage remembers former images, so near ranges need an image of their own, which comes at each ping.
    """
    _check_numbers(ping)
    per_plane, rest = divmod(ping.beams, ping.planes)
    if rest:
        raise PingError(f"{ping.beams} beams do not make {ping.planes} planes")
    bearing = _beam_table(ping.bearing_rad, ping.beams, "bearing_rad")
    elevation = _beam_table(ping.elevation_rad or [0.0] * ping.beams, ping.beams, "elevation_rad")
    first = max(0, math.ceil((max(settings.min_range_m, 0.0) - ping.range0_m) / ping.dr_m - 1e-9))
    if first >= ping.samples:
        raise PingError(f"no sample lies beyond pipeline.min_range_m, {settings.min_range_m} m")
    fans = []
    for plane in range(ping.planes):
        rows = slice(plane * per_plane, (plane + 1) * per_plane)
        if np.any(np.diff(bearing[rows]) <= 0.0):
            raise PingError("bearing_rad does not increase from beam to beam")
        width = _beam_width(ping, bearing, rows, settings)
        fans.append(
            Fan(bearing[rows], width, ping.samples - first, ping.range0_m + first * ping.dr_m, ping.dr_m,
                float(elevation[rows].mean()))
        )  # fmt: skip
    attention = settings.attention
    phases = rings_of(fans[0], attention)
    images = [
        layout(fan, slice(plane * per_plane, (plane + 1) * per_plane), first, rings, attention, phase)
        for plane, fan in enumerate(fans)
        for rings, phase in scheduled(phases, apart=over_pings)
    ]
    return Plan(
        images=images,
        phases=len(phases),
        processed_ranges_m=[[] if phases == [[ALL]] else [(ring.from_m, min(ring.to_m, MAX_RANGE)) for ring in rings]
                for rings in phases],
        first=first,
        sector=_sector(fans, math.radians(settings.vertical_half_deg)),
    )  # fmt: skip


class RangeInterval(NamedTuple):
    """A ring of ranges, m."""

    from_m: float
    to_m: float


ALL = RangeInterval(0.0, math.inf)


def rings_of(fan: Fan, attention: AttentionSettings) -> list[list[RangeInterval]]:
    """Return, for each phase, the rings that are processed, near first [SSIE, focus of attention]."""
    end = fan.range0_m + fan.samples * fan.dr_m
    if not max(0.0, fan.range0_m) < attention.near_m < end or attention.every == 1:
        return [[ALL]]
    borders = [*np.linspace(attention.near_m, end, attention.every + 1)[:-1].tolist(), math.inf]
    near = RangeInterval(0.0, attention.near_m)
    return [[near, RangeInterval(begin, stop)] for begin, stop in pairwise(borders)]


def scheduled(phases: list[list[RangeInterval]], *, apart: bool) -> list[tuple[list[RangeInterval], int]]:
    """Return the rings that share an image, and the image's phase; rings that touch are one."""
    if len(phases) == 1:
        return [(phases[0], EVERY_PHASE)]
    if apart:
        return [(phases[0][:1], EVERY_PHASE), *(([far], phase) for phase, (_, far) in enumerate(phases))]
    near, far = phases[0]
    return [
        ([RangeInterval(near.from_m, far.to_m)], 0),
        *((rings, phase) for phase, rings in enumerate(phases) if phase),
    ]


def layout(
    fan: Fan, rows: slice, first: int, rings: list[RangeInterval], attention: AttentionSettings, phase: int
) -> ImageLayout:
    """Lay rings and their margins side by side. fan, first: of the whole plane."""
    stride = min(attention.subsample, fan.samples)
    margin = attention.margin_m
    dr = stride * fan.dr_m
    parts: list[RangeBand] = []
    filled = 0
    for ring in rings:
        begin = max(0, math.floor((ring.from_m - margin - fan.range0_m) / fan.dr_m))
        stop = min(fan.samples, math.ceil(min((ring.to_m + margin - fan.range0_m) / fan.dr_m, MAX_RANGE)))
        count = max(1, (stop - begin) // stride)
        before = min(begin, fan.samples - count * stride) - filled * stride
        range0 = fan.range0_m + (before + 0.5 * (stride - 1)) * fan.dr_m
        columns = slice(filled, filled + count)
        parts.append(RangeBand(columns, replace(fan, samples=filled + count, range0_m=range0, dr_m=dr),
                          first + before, ring.from_m, ring.to_m))  # fmt: skip
        filled += count
    whole = replace(parts[0].fan, samples=filled)
    if len(parts) > 1:
        skipped = parts[1].fan.range0_m - parts[0].fan.range0_m
        whole = replace(whole, seam=parts[1].columns.start, skipped_m=skipped)
    return ImageLayout(whole, rows, stride, parts, phase)


def _check_numbers(ping: Ping) -> None:
    if not (math.isfinite(ping.dr_m) and ping.dr_m > 0.0):
        raise PingError(f"dr_m: {ping.dr_m} is not a sample spacing")
    if not math.isfinite(ping.range0_m):
        raise PingError(f"range0_m: {ping.range0_m} is not a range")


def _beam_table(values: list[float], beams: int, name: str) -> Floats:
    table = np.array(values, np.float64)
    if len(table) != beams:
        raise PingError(f"{name} has {len(table)} entries for {beams} beams")
    if not np.all(np.abs(table) <= MAX_BEARING):  # NaN fails too
        raise PingError(f"{name} has entries that are no angles")
    return table


def _beam_width(ping: Ping, bearing: Floats, rows: slice, settings: PipelineSettings) -> Floats:
    """Return the (beams,) widths of one plane: as the ping tells, else as configured, else the spacing."""
    if ping.beam_width_rad:
        width = _beam_table(ping.beam_width_rad, ping.beams, "beam_width_rad")[rows]
        if np.any(width <= 0.0):
            raise PingError("beam_width_rad has entries that are no widths")
        return width
    configured = math.radians(settings.beam_width_deg)
    if configured > 0.0:
        return np.full(len(bearing[rows]), configured)
    return np.diff(beam_borders(bearing[rows], math.radians(1.0)))


def _sector(fans: list[Fan], vertical_half_rad: float) -> Sector:
    elevations = [fan.elevation_rad for fan in fans]
    return Sector(
        range_min_m=max(0.0, fans[0].range0_m - 0.5 * fans[0].dr_m),
        range_max_m=fans[0].range0_m + (fans[0].samples - 0.5) * fans[0].dr_m,
        bearing_min_rad=float(min(fan.borders_rad[0] for fan in fans)),
        bearing_max_rad=float(max(fan.borders_rad[-1] for fan in fans)),
        half_vertical_rad=0.5 * (max(elevations) - min(elevations)) + vertical_half_rad,
    )
