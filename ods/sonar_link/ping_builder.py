"""The one place where decoded samples become a `Ping`: checks geometry and samples, whatever format they came from."""

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from ods.base.arrays import AnyArray, Floats, Indices, Mask
from ods.base.clock import NS
from ods.messages import Ping, RangeGrid, SampleType, Scale

MAX_BEAMS = 4096
MAX_SAMPLES = 65536
MAX_PLANES = 64
MAX_FRAME_BYTES = 32 * 1024 * 1024
SOUND_SPEEDS = (20.0, 10_000.0)
"""m/s: nothing else is a number for one. What is not water's, the pipeline refuses by name."""
SAMPLE_SPACINGS = (1e-5, 10.0)
"""m."""
MAX_RANGE_M = 20_000.0

_SAMPLE_TYPES: dict[np.dtype[np.generic], SampleType] = {
    np.dtype(np.uint8): "u1",
    np.dtype("<u2"): "u2",
    np.dtype("<f4"): "f4",
}


@dataclass(frozen=True, eq=False)
class BeamTable:
    """Where the beams look. Made by `make_beam_table`, which checks it."""

    bearing_rad: Floats
    """(beams,) starboard positive, strictly increasing within a plane."""
    elevation_rad: Floats
    """(beams,) up positive."""
    width_rad: Floats
    """(beams,) horizontal -3 dB width; (0,) when not reported."""
    planes: int

    def part(self, rows: Indices) -> "BeamTable":
        """Return the table of the beams with these numbers. Raises ValueError when they do not make one."""
        beams = self.bearing_rad.size
        if np.array_equal(rows, np.arange(beams)):
            return self
        if np.any(rows >= beams):
            raise ValueError(f"beam table: beam {rows.max()} does not exist, there are {beams}")
        width = self.width_rad[rows] if self.width_rad.size else self.width_rad
        return make_beam_table(self.bearing_rad[rows], self.elevation_rad[rows], width)


@dataclass(frozen=True, eq=False)
class Geometry:
    """Geometry of a ping's samples. The numbers are checked: raises ValueError that names the wrong one."""

    table: BeamTable
    range0_m: float
    """Slant range of the first sample's centre."""
    dr_m: float
    sound_speed: float
    frequency_hz: float = 0.0
    scale: Scale = field(default="linear")
    scale_factor: float = 1.0

    def __post_init__(self) -> None:
        _refuse_outside("sound_speed", self.sound_speed, *SOUND_SPEEDS)
        _refuse_outside("dr_m", self.dr_m, *SAMPLE_SPACINGS)
        _refuse_outside("range0_m", self.range0_m, 0.0, MAX_RANGE_M)
        _refuse_outside("frequency_hz", self.frequency_hz, 0.0, 1e9)
        _refuse_outside("scale_factor", self.scale_factor, 1e-9, 1e9)


def make_beam_table(bearing_rad: ArrayLike, elevation_rad: ArrayLike, width_rad: ArrayLike = ()) -> BeamTable:
    """Return the table of (beams,) angles; its planes are the distinct elevations, stacked plane by plane.

    Bearings that rise over the whole table make one plane, whatever the elevations. Widths that are not all positive
    count as not reported. Raises ValueError for what cannot be a beam table.
    """
    bearing, elevation, width = (np.asarray(a, np.float64).reshape(-1) for a in (bearing_rad, elevation_rad, width_rad))
    if not 1 <= bearing.size <= MAX_BEAMS or elevation.size != bearing.size:
        raise ValueError(f"beam table: {bearing.size} bearings and {elevation.size} elevations")
    # written so that NaN is refused
    if not (np.all(np.abs(bearing) <= math.pi) and np.all(np.abs(elevation) <= math.pi / 2)):
        raise ValueError("beam table: an angle is not a number, or out of range")
    if not (width.size == bearing.size and np.all((width > 0.0) & (width <= math.pi))):
        width = np.empty(0)
    return BeamTable(bearing, elevation, width, _planes(bearing, elevation))


def _planes(bearing: Floats, elevation: Floats) -> int:
    if np.all(np.diff(bearing) > 0.0):
        return 1
    planes = len(np.unique(elevation))
    if planes > MAX_PLANES or bearing.size % planes:
        raise ValueError(f"beam table: {bearing.size} beams do not make {planes} planes")
    rows = elevation.reshape(planes, -1)
    if not np.all(rows == rows[:, :1]) or not np.all(np.diff(bearing.reshape(planes, -1), axis=1) > 0.0):
        raise ValueError("beam table: bearings do not increase strictly within a plane")
    return planes


class Stamp(NamedTuple):
    """Which ping it is and when it was; see the fields of `Ping`."""

    seq: int
    ping_number: int
    t_ns: int
    t_rx_ns: int
    utc_ns: int = 0


Runs = list[tuple[int, int, int]]
"""See `Ping.no_data`."""


def build_ping(frame: AnyArray, geometry: Geometry, stamp: Stamp, no_data: Runs | None = None) -> Ping:
    """Return the ping of a (beams, samples) frame of uint8, uint16 or float32, in any memory order.

    no_data: runs of samples of the frame that hold none; None: all do.

    Raises ValueError when the frame does not fit the beam table or holds what is no amplitude.
    """
    table = geometry.table
    sample_type = _SAMPLE_TYPES.get(frame.dtype)
    if sample_type is None:
        raise ValueError(f"frame: sample type {frame.dtype} is not one of uint8, uint16, float32")
    if frame.ndim != 2 or frame.shape[0] != table.bearing_rad.size:
        raise ValueError(f"frame: shape {frame.shape} does not fit {table.bearing_rad.size} beams")
    if not 1 <= frame.shape[1] <= MAX_SAMPLES or frame.nbytes > MAX_FRAME_BYTES:
        raise ValueError(f"frame: shape {frame.shape} is empty or too large")
    if sample_type == "f4" and not np.isfinite(frame.astype(np.float32, copy=False)).all():
        raise ValueError("frame: a sample is not a finite number")
    return Ping(
        seq=stamp.seq,
        ping_number=stamp.ping_number,
        t_ns=stamp.t_ns,
        t_rx_ns=stamp.t_rx_ns,
        utc_ns=stamp.utc_ns,
        beams=frame.shape[0],
        samples=frame.shape[1],
        dtype=sample_type,
        data=frame.tobytes(),
        bearing_rad=table.bearing_rad.tolist(),
        range0_m=geometry.range0_m,
        dr_m=geometry.dr_m,
        sound_speed=geometry.sound_speed,
        elevation_rad=table.elevation_rad.tolist() if np.any(table.elevation_rad) else [],
        beam_width_rad=table.width_rad.tolist(),
        planes=table.planes,
        frequency_hz=geometry.frequency_hz,
        scale=geometry.scale,
        scale_factor=geometry.scale_factor,
        no_data=no_data or [],
    )


def build_range_ping(frame: AnyArray, geometry: Geometry, stamp: Stamp, grid: RangeGrid) -> Ping:
    """Return the ping of a range image, (bearings, elevations) of uint8 or uint16.

    Raises ValueError when the frame does not fit its directions.
    """
    elevation = np.asarray(grid.elevation_rad)
    if frame.dtype.kind != "u" or frame.shape[1:] != elevation.shape or not np.all(np.diff(elevation) > 0.0):
        raise ValueError(
            f"frame: {frame.shape} of {frame.dtype} is not an image of ranges in {elevation.size} elevations"
        )
    _refuse_outside("range_max_m", grid.range_max_m, 0.01, MAX_RANGE_M)
    return msgspec.structs.replace(build_ping(frame, geometry, stamp), range_grid=grid)


def runs_beyond(lengths: ArrayLike, samples: int) -> Runs:
    """Return `Ping.no_data` of beams of which only the first `lengths`, (beams,), of the samples hold data."""
    return [(beam, length, samples) for beam, length in enumerate(np.asarray(lengths).tolist()) if length < samples]


def runs_where(mask: Mask) -> Runs:
    """Return `Ping.no_data` of the samples marked in a mask (beams, samples)."""
    steps = np.diff(np.pad(mask, ((0, 0), (1, 1))).astype(np.int8), axis=1)
    beam, first = np.nonzero(steps == 1)
    stop = np.nonzero(steps == -1)[1]
    return list(zip(beam.tolist(), first.tolist(), stop.tolist(), strict=True))


def listening_ns(ping: Ping) -> int:
    """Return the time from transmission until the echo of the last sample's centre is back, ns."""
    last_m = farthest_m(ping)
    return round(2.0 * last_m / ping.sound_speed * NS)


def farthest_m(ping: Ping) -> float:
    """Return the slant range of the last sample's centre, or the longest range of a range image, m."""
    if ping.range_grid is not None:
        return ping.range_grid.range_max_m
    return ping.range0_m + (ping.samples - 1) * ping.dr_m


def _refuse_outside(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:  # false for NaN too
        raise ValueError(f"{name}: {value:g} lies outside {low:g} to {high:g}")
