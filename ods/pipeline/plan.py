"""What the geometry of a ping decides once, for all pings that share it: planes, sector, amplitude table."""

import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.messages import SAMPLE_DTYPES, Ping, Sector
from ods.pipeline.amplitude import Table, amplitude_table
from ods.pipeline.fan import Fan, beam_borders
from ods.pipeline.settings import AttentionSettings, PipelineSettings

MAX_BEARING = math.pi
MAX_RANGE = 1e6
"""Stands for 'as far as the image reaches', m."""


class PingError(ValueError):
    """A ping cannot be processed: its tables or samples are wrong; the text says why in one line."""


EVERY_TURN = -1


@dataclass(frozen=True, eq=False)
class Part:
    """Rows and columns of the frame that are processed together: a plane, or some of its ranges."""

    fan: Fan
    rows: slice
    first: int
    """Samples that lie before the first column of the image."""
    stride: int = 1
    """Range samples that make one column."""
    turn: int = EVERY_TURN
    """The ping, modulo `Plan.turns`, at which it is processed."""
    partial: bool = False
    """It answers only for echoes from `from_m` to `to_m`; the rest is margin."""
    from_m: float = 0.0
    to_m: float = math.inf


@dataclass(frozen=True, eq=False)
class Plan:
    """What all pings of one geometry have in common."""

    parts: list[Part]
    turns: int
    """Pings after which all parts had their turn."""
    looked: list[list[tuple[float, float]]]
    """For each turn, the ranges (from, to) that are processed, m; none: all."""
    first: int
    """Samples nearer than the least range."""
    sector: Sector
    table: Table | None
    """Linear amplitude of every count, where a table serves."""


def geometry_key(ping: Ping) -> tuple[Any, ...]:
    """Return what a plan depends on; pings with equal keys share a plan."""
    return (
        ping.beams, ping.samples, ping.dtype, ping.planes, ping.range0_m, ping.dr_m, ping.scale, ping.scale_factor,
        ping.bearing_rad, ping.elevation_rad, ping.beam_width_rad,
    )  # fmt: skip


def make_plan(ping: Ping, settings: PipelineSettings) -> Plan:
    """Check the ping's tables and lay the plan out. Raises PingError."""
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
    whole = [
        Part(fan, slice(plane * per_plane, (plane + 1) * per_plane), first) for plane, fan in enumerate(fans)
    ]  # fmt: skip
    zones = zones_of(fans[0], settings.attention)
    return Plan(
        parts=[cut(part, zone) for part in whole for zone in zones],
        turns=max(1, 1 + max(zone.turn for zone in zones)),
        looked=looked(zones),
        first=first,
        sector=_sector(fans, math.radians(settings.vertical_half_deg)),
        table=amplitude_table(SAMPLE_DTYPES[ping.dtype], ping.scale, ping.scale_factor),
    )


class Zone(NamedTuple):
    """A ring of ranges."""

    from_m: float
    to_m: float
    margin_m: float
    stride: int
    turn: int


def zones_of(fan: Fan, attention: AttentionSettings) -> list[Zone]:
    """Return the rings that the range is parted into [SSIE, focus of attention]."""
    end = fan.range0_m + fan.samples * fan.dr_m
    stride = attention.subsample
    if not 0.0 < attention.near_m < end or attention.every == 1:
        return [Zone(0.0, math.inf, 0.0, stride, EVERY_TURN)]
    borders = np.linspace(attention.near_m, end, attention.every + 1).tolist()
    near = Zone(0.0, borders[0], attention.margin_m, stride if attention.near_too else 1, EVERY_TURN)
    far = [
        Zone(a, b, attention.margin_m, stride, turn)
        for turn, (a, b) in enumerate(zip(borders[:-1], [*borders[1:-1], math.inf], strict=True))
    ]
    return [near, *far]


def looked(zones: list[Zone]) -> list[list[tuple[float, float]]]:
    """Return the ranges that are processed at each turn; nothing when it is all."""
    if len(zones) == 1:
        return [[]]
    return [[(zone.from_m, min(zone.to_m, MAX_RANGE)) for zone in (zones[0], far)] for far in zones[1:]]


def cut(part: Part, zone: Zone) -> Part:
    """Return the columns of a plane that a zone and its margins reach over."""
    fan = part.fan
    begin = max(0, math.floor((zone.from_m - zone.margin_m - fan.range0_m) / fan.dr_m))
    stop = fan.samples
    if zone.to_m < math.inf:
        stop = min(stop, math.ceil((zone.to_m + zone.margin_m - fan.range0_m) / fan.dr_m))
    columns = max(1, (stop - begin) // zone.stride)
    stride = min(zone.stride, stop - begin)
    middle = begin + 0.5 * (stride - 1)
    ring = replace(fan, samples=columns, range0_m=fan.range0_m + middle * fan.dr_m, dr_m=stride * fan.dr_m)
    return Part(
        ring, part.rows, part.first + begin, stride, zone.turn, zone.turn != EVERY_TURN or zone.to_m < math.inf,
        zone.from_m, zone.to_m,
    )  # fmt: skip


def _check_numbers(ping: Ping) -> None:
    if not (math.isfinite(ping.dr_m) and ping.dr_m > 0.0):
        raise PingError(f"dr_m: {ping.dr_m} is not a sample spacing")
    if not math.isfinite(ping.range0_m):
        raise PingError(f"range0_m: {ping.range0_m} is not a range")
    if ping.scale != "linear" and not (math.isfinite(ping.scale_factor) and ping.scale_factor > 0.0):
        raise PingError(f"scale_factor: {ping.scale_factor} does not fit scale {ping.scale}")


def _beam_table(values: list[float], beams: int, name: str) -> NDArray[np.float64]:
    table = np.array(values, np.float64)
    if len(table) != beams:
        raise PingError(f"{name} has {len(table)} entries for {beams} beams")
    if not np.all(np.abs(table) <= MAX_BEARING):  # NaN fails too
        raise PingError(f"{name} has entries that are no angles")
    return table


def _beam_width(
    ping: Ping, bearing: NDArray[np.float64], rows: slice, settings: PipelineSettings
) -> NDArray[np.float64]:
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
