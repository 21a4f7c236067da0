"""Blueprint Oculus recordings (.raw): the sonar's network stream, of which simple ping results version 1 are read.

Source: liboculus of the Applied Physics Laboratory, University of Washington (message layout), and its ROS driver
(range of a line). The stream's ping start time has no documented unit, so pings come without times.
"""

import struct
from collections import Counter
from collections.abc import Iterator
from mmap import mmap
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import AnyArray, Floats32
from ods.messages import Ping
from ods.sonar_link.files.decoder import Decoder
from ods.sonar_link.files.mapped_file import map_file
from ods.sonar_link.files.ping_sequence import LazyPings, PingFileError, PingSequence, recorded_ping
from ods.sonar_link.ping_builder import Geometry, make_beam_table

SIGNATURE = b"SO"
SIMPLE_PING_RESULT = 0x23
KINDS = (0x15, 0x22, SIMPLE_PING_RESULT, 0x55, 0x80, 0xFF)
"""Message identifiers of the protocol."""
SECOND_VERSION = 2
SENDS_GAIN = 1 << 2
GAIN_BYTES = 4
"""Of the gain before each line, when sent."""
SAMPLE_DTYPES: dict[int, np.dtype[np.unsignedinteger]] = {0: np.dtype(np.uint8), 1: np.dtype("<u2")}
FULL_GAMMA = 255
BEARING_STEP = np.radians(0.01)

_MESSAGE = struct.Struct("<2sHHHHIH")
# Of the fire message: gamma, flags. Of the ping result: number; frequency; sound speed; sample size, spacing, lines,
# beams, image offset and size.
_RESULT = struct.Struct("<16x3xBB32xI4xd16xd4xBdHHII4x")


class _Result(NamedTuple):
    gamma: int
    flags: int
    ping_number: int
    frequency_hz: float
    sound_speed: float
    sample_size: int
    dr_m: float
    lines: int
    beams: int
    image_offset: int
    image_bytes: int


class OculusDecoder(Decoder):
    """Counts `other_messages`, `corrupt_pings` and `garbage_bytes`."""

    name = "Oculus .raw"
    signature = ((0, SIGNATURE),)
    suffix = ".raw"

    def read(self, path: Path) -> PingSequence:
        """Read a recording. Raises PingFileError."""
        data = map_file(path)
        losses: Counter[str] = Counter()
        found: list[tuple[int, int]] = []
        for offset, size in _results(data, losses):
            try:
                _ping(data, offset, size, 0)
            except ValueError:
                losses["corrupt_pings"] += 1
            else:
                found.append((offset, size))
        if not found:
            raise PingFileError(f"{path}: no whole simple ping result in it")
        pings = LazyPings(len(found), lambda index: _ping(data, *found[index], index))
        return PingSequence(pings, timed=False, losses=losses)


def _results(data: mmap, losses: Counter[str]) -> Iterator[tuple[int, int]]:
    """Yield offset and size of each whole simple ping result of version 1; count all else."""
    offset = 0
    while offset + _MESSAGE.size <= len(data):
        signature, _, _, kind, version, payload, _ = _MESSAGE.unpack_from(data, offset)
        following = offset + _MESSAGE.size + payload
        if signature != SIGNATURE or kind not in KINDS or following > len(data):
            found = data.find(SIGNATURE, offset + 1)
            following = found if found >= 0 else len(data)
            losses["garbage_bytes"] += following - offset
        elif kind != SIMPLE_PING_RESULT or version == SECOND_VERSION or following - offset < _RESULT.size:
            losses["other_messages"] += 1
        else:
            yield offset, following - offset
        offset = following
    if offset < len(data):
        losses["garbage_bytes"] += len(data) - offset


def _ping(data: mmap, offset: int, size: int, index: int) -> Ping:
    """Decode one message. Raises ValueError when its numbers do not fit each other."""
    result = _Result._make(_RESULT.unpack_from(data, offset))
    bearing = np.frombuffer(data, "<i2", result.beams, offset + _RESULT.size) * BEARING_STEP
    geometry = Geometry(
        table=make_beam_table(bearing, np.zeros(bearing.size)),
        range0_m=0.5 * result.dr_m,
        dr_m=result.dr_m,
        sound_speed=result.sound_speed,
        frequency_hz=result.frequency_hz,
    )
    counts = _lines(data[offset : offset + size], result)
    linear = result.gamma in (0, FULL_GAMMA)
    frame: AnyArray = counts if linear else _undo_gamma(counts, result.gamma / FULL_GAMMA)
    return recorded_ping(frame.T, geometry, index, ping_number=result.ping_number)


def _lines(message: bytes, result: _Result) -> NDArray[np.unsignedinteger]:
    """Return the (lines, beams) samples. Raises ValueError when the message does not hold them."""
    dtype = SAMPLE_DTYPES.get(result.sample_size)
    if dtype is None:
        raise ValueError(f"sample size {result.sample_size} is not supported")
    gain_bytes = GAIN_BYTES if result.flags & SENDS_GAIN else 0
    line_bytes = gain_bytes + result.beams * dtype.itemsize
    image = np.frombuffer(message, np.uint8, result.lines * line_bytes, result.image_offset)
    if result.image_bytes != image.size or result.image_offset < _RESULT.size + 2 * result.beams:
        raise ValueError("image size and shape differ")
    return np.ascontiguousarray(image.reshape(result.lines, line_bytes)[:, gain_bytes:]).view(dtype)


def _undo_gamma(counts: NDArray[np.unsignedinteger], gamma: float) -> Floats32:
    """Return amplitudes on the same full scale, of which the sonar sent the power `gamma`."""
    full_scale = np.iinfo(counts.dtype).max
    table = np.asarray(full_scale * np.linspace(0.0, 1.0, full_scale + 1) ** (1.0 / gamma), np.float32)
    linear: Floats32 = table[counts]
    return linear
