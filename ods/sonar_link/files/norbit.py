"""Norbit WBMS recordings: the stream of its image port as it comes, such as `nc SONAR 2211 > dive.wbms` writes it."""

from collections import Counter
from collections.abc import Iterator
from mmap import mmap
from pathlib import Path

from ods.base.clock import NS
from ods.messages import Ping
from ods.sonar_link.files.decoder import Decoder
from ods.sonar_link.files.mapped_file import memory_map
from ods.sonar_link.files.ping_sequence import LazyPings, PingFileError, PingSequence, recorded_ping
from ods.sonar_link.norbit import image, packets
from ods.sonar_link.norbit.framer import fault_of
from ods.sonar_link.norbit.packets import PREAMBLE, SAMPLE_TYPES, PacketKind

LATEST_S = 2**33
"""A time, UTC seconds since 1970, is not beyond the year 2242."""


class NorbitDecoder(Decoder):
    """Counts `other_messages`, `corrupt_pings` and `garbage_bytes`.

    A ping's time is that of its transmission by the sonar's clock: UTC where it has a time server.
    """

    name = "Norbit .wbms"
    signature = ((0, PREAMBLE),)
    suffix = ".wbms"

    def read(self, path: Path) -> PingSequence:
        """Read a recording. Raises PingFileError."""
        data = memory_map(path)
        losses: Counter[str] = Counter()
        found: list[int] = []
        for offset in _images(data, losses):
            try:
                _ping(data, offset, 0)
            except ValueError:
                losses["corrupt_pings"] += 1
            else:
                found.append(offset)
        if not found:
            raise PingFileError(f"{path}: no whole image of a Norbit WBMS in it")
        return PingSequence(LazyPings(len(found), lambda index: _ping(data, found[index], index)), losses=losses)


def _images(data: mmap, losses: Counter[str]) -> Iterator[int]:
    """Yield the offset of each whole image; count all else."""
    offset = 0
    while offset < len(data):
        fault = fault_of(data, offset)
        header = packets.unpack_header(data, offset) if fault == "" else None
        if header is None or offset + header.size > len(data) or not _is_sound(data, offset, header):
            losses["corrupt_pings"] += fault in ("", "bad_ping")
            found = data.find(PREAMBLE, offset + 1)
            following = found if found >= 0 else len(data)
            losses["garbage_bytes"] += following - offset
        else:
            following = offset + header.size
            if header.kind == PacketKind.IMAGE:
                yield offset
            else:
                losses["other_messages"] += 1
        offset = following


def _is_sound(data: mmap, offset: int, header: packets.Header) -> bool:
    return packets.is_sound(memoryview(data)[offset : offset + header.size], header)


def _ping(data: mmap, offset: int, index: int) -> Ping:
    """Decode one packet. Raises ValueError when its numbers do not fit each other."""
    head = packets.decode_image_head(data, offset)
    if head.sample_type not in SAMPLE_TYPES:
        raise ValueError(f"samples of type {head.sample_type}")
    if not 0.0 <= head.time_s < LATEST_S:
        raise ValueError("no time")
    frame, geometry = image.amplitudes_of(head, data, offset), image.geometry_of(head, data, offset)
    return recorded_ping(frame, geometry, index, round(head.time_s * NS), head.ping_number)
