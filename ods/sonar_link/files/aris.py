"""SoundMetrics .aris recordings.

A 1024-byte file header, then frames: a 1024-byte header and samples x beams bytes, 0 to 255 for 0 to 80 dB, beam 0 at
the right. Source: the public ARIS File SDK of SoundMetrics (type-definitions, docs/understanding-aris-data.md).
"""

import struct
from collections import Counter
from mmap import mmap
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ods.messages import Ping
from ods.sonar_link.files.decoder import START_BYTES, Decoder
from ods.sonar_link.files.mapped_file import memory_map
from ods.sonar_link.files.ping_sequence import LazyPings, PingFileError, PingSequence, recorded_ping
from ods.sonar_link.ping_builder import MAX_SAMPLES, Geometry, make_beam_table

SIGNATURE = b"DDF\x05"
ARIS_HEADER_BYTES = 1024
DB_PER_COUNT = 80.0 / 255.0
US = 1e-6
NS_PER_US = 1000

BEAMS_OF_PING_MODE = {1: 48, 2: 48, 3: 96, 4: 96, 5: 96, 6: 64, 7: 64, 8: 64, 9: 128, 10: 128, 11: 128, 12: 128}
FREQUENCIES_HZ = {0: (1.1e6, 1.8e6), 1: (1.8e6, 3.0e6), 2: (0.7e6, 1.2e6)}
"""Low and high frequency of the ARIS 1800, 3000, 1200."""

BEARINGS_DEG = {
    (48, False): (0.0, 16.090, 0.0, -3.331, 0.0, 0.820),
    (64, False): (0.0, 15.008, 0.0, -0.059, 0.0, -0.061),
    (96, False): (-0.001, 16.322, 0.101, -3.262, -0.037, 0.757),
    (128, False): (0.0, 15.132, 0.001, -0.065, 0.003, -0.054),
    (48, True): (0.0, 7.510, 0.0, -0.128, 0.0, -0.045),
    (96, True): (0.0, 7.591, 0.0, -0.125, 0.0, -0.049),
}
"""(beams, telephoto lens): polynomial of the beam centres over -1..1 from the left beam to the right one, degrees.

Fitted to the SDK's tables in beam-width-metrics/; off by 0.01 degrees, or 0.03 beams, at most.
"""

# Fields of the frame header and where they stand: time us u64; signature; ping mode, high frequency; sample period us;
# sound speed; samples; start delay us, telephoto lens, system type; samples in order.
_FIELDS = struct.Struct("<4xQ4s420xII8xI8xfI4xIII28xI")


class _FrameHeader(NamedTuple):
    time_us: int
    signature: bytes
    ping_mode: int
    high_frequency: int
    sample_period_us: int
    sound_speed: float
    samples: int
    start_delay_us: int
    telephoto: int
    system_type: int
    in_order: int


class ArisDecoder(Decoder):
    """Counts `corrupt_frames` and `truncated_frames`."""

    name = ".aris"
    signature = ((0, SIGNATURE),)
    suffix = ".aris"

    def read(self, path: Path) -> PingSequence:
        """Read a recording. Raises PingFileError."""
        data = memory_map(path)
        if not self.recognizes(data[:START_BYTES]) or len(data) < 2 * ARIS_HEADER_BYTES:
            raise PingFileError(f"{path}: not an ARIS recording")
        first = _header_at(data, ARIS_HEADER_BYTES)
        beams = BEAMS_OF_PING_MODE.get(first.ping_mode, 0)
        if not beams or not 1 <= first.samples <= MAX_SAMPLES or (beams, bool(first.telephoto)) not in BEARINGS_DEG:
            raise PingFileError(f"{path}: the first frame header is corrupt")
        offsets, losses = _whole_frames(data, first)
        if not offsets:
            raise PingFileError(f"{path}: no complete frame in it")
        return PingSequence(LazyPings(len(offsets), lambda index: _ping(data, offsets[index], index)), losses=losses)


def _whole_frames(data: mmap, first: _FrameHeader) -> tuple[list[int], Counter[str]]:
    """Return where the frames of the first one's shape begin, and the count of the others."""
    frame_bytes = ARIS_HEADER_BYTES + BEAMS_OF_PING_MODE[first.ping_mode] * first.samples
    whole, rest = divmod(len(data) - ARIS_HEADER_BYTES, frame_bytes)
    places = [ARIS_HEADER_BYTES + index * frame_bytes for index in range(whole)]
    good = [place for place in places if _geometry_of(_header_at(data, place), like=first) is not None]
    return good, +Counter(truncated_frames=int(rest > 0), corrupt_frames=whole - len(good))


def _header_at(data: mmap, offset: int) -> _FrameHeader:
    return _FrameHeader._make(_FIELDS.unpack_from(data, offset))


def _geometry_of(header: _FrameHeader, like: _FrameHeader) -> Geometry | None:
    """Return the geometry of a frame of the same shape as `like`, None when its header is corrupt."""
    same = (header.ping_mode, header.samples) == (like.ping_mode, like.samples)
    polynomial = BEARINGS_DEG.get((BEAMS_OF_PING_MODE[like.ping_mode], bool(header.telephoto)))
    if not same or header.signature != SIGNATURE or not header.in_order or polynomial is None:
        return None
    metres_per_us = 0.5 * header.sound_speed * US
    across = np.linspace(-1.0, 1.0, BEAMS_OF_PING_MODE[like.ping_mode])
    bearing = np.radians(np.polynomial.polynomial.polyval(across, polynomial))
    try:
        return Geometry(
            table=make_beam_table(bearing, np.zeros(bearing.size)),
            range0_m=header.start_delay_us * metres_per_us,
            dr_m=header.sample_period_us * metres_per_us,
            sound_speed=header.sound_speed,
            frequency_hz=FREQUENCIES_HZ.get(header.system_type, (0.0, 0.0))[bool(header.high_frequency)],
            scale="db",
            scale_factor=DB_PER_COUNT,
        )
    except ValueError:
        return None


def _ping(data: mmap, offset: int, index: int) -> Ping:
    header = _header_at(data, offset)
    geometry = _geometry_of(header, like=header)
    if geometry is None:
        raise PingFileError(f"frame at byte {offset}: changed while the file was read")
    beams = geometry.table.bearing_rad.size
    frame = np.frombuffer(data, np.uint8, beams * header.samples, offset + ARIS_HEADER_BYTES).reshape(-1, beams)
    return recorded_ping(frame[:, ::-1].T, geometry, index, header.time_us * NS_PER_US)
