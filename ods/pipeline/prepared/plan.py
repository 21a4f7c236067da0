"""All that follows from the geometry of a ping, for all pings that share it: planes, rings of attention, sector."""

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import msgspec
import numpy as np

from ods.base.arrays import SAMPLE_DTYPES, Floats
from ods.messages import Ping, Sector
from ods.pipeline.image.fan import Fan, beam_borders
from ods.pipeline.image.image_layout import MAX_RANGE, ImageLayout, layout, rings_of, scheduled
from ods.pipeline.image.samples.amplitude import SampleScale, sample_scale
from ods.pipeline.settings import PipelineSettings

MAX_BEARING = math.pi
ALIKE = 0.05
"""Of ranges: sound speeds of the sea are within that of each other."""


class PingError(ValueError):
    """A ping cannot be processed: its tables or samples are wrong; the text says why in one line."""


@dataclass(frozen=True, eq=False)
class Plan:
    """Common data of all pings of one geometry."""

    settings: PipelineSettings
    """With all numbers, as they are for its range samples."""
    images: list[ImageLayout]
    processed_ranges_m: list[list[tuple[float, float]]]
    """For each phase, the ranges (from, to) that are processed, m; none: all. After so many pings all images had their
    turn."""
    first: int
    """Number of samples nearer than `min_range_m`."""
    sector: Sector


def geometry_key(ping: Ping) -> tuple[Any, ...]:
    """Return what a plan depends on; pings with equal keys share a plan."""
    return (
        ping.beams, ping.samples, ping.planes, ping.range0_m, ping.dr_m,
        ping.bearing_rad, ping.elevation_rad, ping.beam_width_rad,
    )  # fmt: skip


def sample_scale_of(ping: Ping) -> SampleScale:
    """Return how the ping's samples become amplitudes. Raises PingError."""
    if ping.scale != "linear" and not (math.isfinite(ping.scale_factor) and ping.scale_factor > 0.0):
        raise PingError(f"scale_factor: {ping.scale_factor} does not fit scale {ping.scale}")
    return sample_scale(SAMPLE_DTYPES[ping.dtype], ping.scale, ping.scale_factor)


def make_plan(ping: Ping, settings: PipelineSettings, *, over_pings: bool = False) -> Plan:
    """Check the ping's tables and lay the plan out. Raises PingError.

    over_pings: a stage remembers former images, so near ranges need an image of their own, which comes at each ping.
    """
    _check_numbers(ping)
    settings = settings.at_spacing(ping.dr_m)
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
        settings=settings,
        images=images,
        processed_ranges_m=[[] if len(phases) == 1 else [(ring.from_m, min(ring.to_m, MAX_RANGE)) for ring in rings]
                for rings in phases],
        first=first,
        sector=_sector(fans, math.radians(settings.vertical_half_deg)),
    )  # fmt: skip


def are_alike(one: Plan, other: Plan, *, over_pings: bool) -> bool:
    """Return whether stages prepared for one plan will do for the other: only ranges differ, by `ALIKE` or less.

    So they do where a sonar takes them from a sound speed that it measures again for each ping. over_pings: the stages
    compare pings, so what lies at a column must not move.
    """
    share = 0.0 if over_pings else ALIKE
    return len(one.images) == len(other.images) and all(
        _has_same_columns(a, b, share) for a, b in zip(one.images, other.images, strict=True)
    )


def _has_same_columns(one: ImageLayout, other: ImageLayout, share: float) -> bool:
    a, b = one.fan, other.fan
    if (one.rows, one.stride, one.phase, a.shape, a.seam) != (other.rows, other.stride, other.phase, b.shape, b.seam):
        return False
    near, far = ((fan.range0_m, fan.dr_m, fan.range_m[-1]) for fan in (a, b))
    return (
        a.elevation_rad == b.elevation_rad
        and np.array_equal(one.origin, other.origin)
        and np.array_equal(a.bearing_rad, b.bearing_rad)
        and np.array_equal(a.beam_width_rad, b.beam_width_rad)
        and all(abs(x - y) <= share * abs(x) for x, y in zip(near, far, strict=True))
    )


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
        raise PingError(f"{name} has entries that are not angles")
    return table


def _beam_width(ping: Ping, bearing: Floats, rows: slice, settings: PipelineSettings) -> Floats:
    """Return the (beams,) widths of one plane: those of the ping, otherwise the configured ones, otherwise the
    spacing."""
    if ping.beam_width_rad:
        width = _beam_table(ping.beam_width_rad, ping.beams, "beam_width_rad")[rows]
        if np.any(width <= 0.0):
            raise PingError("beam_width_rad has entries that are not widths")
        return width
    configured = math.radians(settings.beam_width_deg)
    if configured > 0.0:
        return np.full(len(bearing[rows]), configured)
    return np.diff(beam_borders(bearing[rows], math.radians(1.0)))


def _sector(fans: list[Fan], vertical_half_rad: float) -> Sector:
    elevations = sorted({fan.elevation_rad for fan in fans})
    gaps = [high - low for low, high in pairwise(elevations)]
    stack = Sector(
        range_min_m=max(0.0, fans[0].range0_m - 0.5 * fans[0].dr_m),
        range_max_m=fans[0].range0_m + (fans[0].samples - 0.5) * fans[0].dr_m,
        bearing_min_rad=float(min(fan.borders_rad[0] for fan in fans)),
        bearing_max_rad=float(max(fan.borders_rad[-1] for fan in fans)),
        half_vertical_rad=0.5 * (elevations[-1] - elevations[0]) + vertical_half_rad,
    )
    if not gaps:
        return stack
    return msgspec.structs.replace(stack, plane_half_rad=min(max(vertical_half_rad, 0.5 * max(gaps)), 0.5 * math.pi))
