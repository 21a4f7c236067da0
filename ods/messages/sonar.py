"""Data of a sonar: a ping, and its samples."""

from typing import TYPE_CHECKING, Annotated

import msgspec

from ods.messages.fields import Angle, Count, Instant, Metres, SampleType, Scale, SoundSpeed

if TYPE_CHECKING:
    from ods.base.arrays import AnyArray  # a planner's computer need not have numpy


class RangeGrid(msgspec.Struct, frozen=True):
    """Marks a ping as a range image: each direction has the range of its strongest echo.

    Column k of `Ping.data` has the elevation `elevation_rad[k]`. A pixel's number times `Ping.dr_m` is the slant
    range; 0: no echo.
    """

    elevation_rad: list[Angle]
    """(samples,) strictly increasing."""
    range_max_m: Annotated[float, msgspec.Meta(gt=0.0, le=1e5)]
    """Largest range at which an echo would have been received."""


class Sweep(msgspec.Struct, frozen=True):
    """How a mechanically scanned head sweeps its sector, one beam at a time."""

    bearing_min_rad: Angle
    """Middle of the first beam."""
    bearing_max_rad: Angle
    """Middle of the last beam."""
    step_rad: Angle
    """From beam to beam."""
    turn_s: Annotated[float, msgspec.Meta(ge=0.0, le=1e4)]
    """Duration of one sweep."""
    rising: bool
    """It turns to starboard."""
    ends: bool = False
    """The head turns back, or jumps, after this ping."""


class Ping(msgspec.Struct, frozen=True):
    """One sonar image with its geometry, or successive beams of a mechanically scanned sonar.

    Planes of a multi-plane sonar are stacked: row `p * beams_per_plane + b`; `beams` counts all rows.
    """

    seq: Count
    ping_number: Count
    t_ns: Instant
    """Transmit time."""
    t_rx_ns: Instant
    utc_ns: Instant
    beams: Annotated[int, msgspec.Meta(ge=1, le=4096)]
    samples: Annotated[int, msgspec.Meta(ge=1, le=65536)]
    dtype: SampleType
    """Of `data`, little endian: u1 uint8, u2 uint16, f4 float32."""
    data: bytes
    """Amplitudes, C order (beams, samples)."""
    bearing_rad: list[Angle]
    """(beams,) strictly increasing within a plane."""
    range0_m: Metres
    """Slant range of the first sample's centre."""
    dr_m: Annotated[float, msgspec.Meta(ge=1e-6, le=100.0)]
    """Sample spacing in slant range."""
    sound_speed: SoundSpeed
    elevation_rad: list[Angle] = []
    """(beams,) empty: all 0."""
    beam_width_rad: list[Angle] = []
    """(beams,) horizontal, -3 dB; empty: not reported."""
    planes: Annotated[int, msgspec.Meta(ge=1, le=64)] = 1
    frequency_hz: Annotated[float, msgspec.Meta(ge=0.0, le=1e9)] = 0.0
    """0: not reported."""
    scale: Scale = "linear"
    """linear: proportional to pressure amplitude; db: decibels; log8: a = scale_factor * log10(linear)."""
    scale_factor: Annotated[float, msgspec.Meta(ge=-1e9, le=1e9)] = 1.0
    """log8: the factor (s7k record 7042, default 40); db: decibels a count."""
    setting: str = ""
    """Such as gain; levels of different settings are not comparable."""
    no_data: list[tuple[int, int, int]] = []
    """Samples without data, as runs (beam, first, stop)."""
    beam_t_ns: list[Instant] = []
    """(beams,) transmit times of a mechanically scanned sonar, `t_ns` the newest; empty: all at `t_ns`."""
    sweep: Sweep | None = None
    """Of a mechanically scanned sonar, whose pings cover 50 degrees at most."""
    range_grid: RangeGrid | None = None
    """Of a 3-D sonar: `data` are ranges."""


def frame_of(ping: Ping) -> "AnyArray":
    """Return the ping's samples, (beams, samples), as a read-only view without copying.

    Raises ValueError when the buffer's length does not fit the shape.
    """
    import numpy as np

    from ods.base.arrays import SAMPLE_DTYPES

    dtype = SAMPLE_DTYPES[ping.dtype]
    if len(ping.data) != ping.beams * ping.samples * dtype.itemsize:
        raise ValueError(f"ping {ping.ping_number}: {len(ping.data)} bytes do not hold {ping.beams} x {ping.samples}")
    return np.frombuffer(ping.data, dtype).reshape(ping.beams, ping.samples)


RANGES_ABOVE = 512
"""Ranges of a range image that is shown as an image."""


def seen_from_above(ping: Ping) -> Ping:
    """Return a range image as an image by bearing and range, for pictures; any other ping as it is.

    Its levels are how many elevations have their echo at each range. Raises ValueError as `frame_of`.
    """
    if ping.range_grid is None:
        return ping
    import numpy as np

    range_m = frame_of(ping).astype(np.float64) * ping.dr_m
    dr_m = ping.range_grid.range_max_m / RANGES_ABOVE
    shown = (range_m > 0.0) & (range_m < ping.range_grid.range_max_m)
    cell = np.nonzero(shown)[0] * RANGES_ABOVE + (range_m[shown] / dr_m).astype(np.intp)
    counted = np.bincount(cell, minlength=ping.beams * RANGES_ABOVE)
    data = np.minimum(counted, 255).astype(np.uint8).tobytes()
    return msgspec.structs.replace(
        ping, samples=RANGES_ABOVE, dtype="u1", data=data, range0_m=0.5 * dr_m, dr_m=dr_m, range_grid=None
    )
