"""Blueprint Oculus recordings (.raw): the sonar's network stream, of which simple ping results are read.

The start time of first-version results has no known unit, so pings come without times.
"""

from collections import Counter
from collections.abc import Iterator
from mmap import mmap
from pathlib import Path

from ods.messages import Ping
from ods.sonar_link.files.decoder import Decoder
from ods.sonar_link.files.mapped_file import memory_map
from ods.sonar_link.files.ping_sequence import LazyPings, PingFileError, PingSequence, recorded_ping
from ods.sonar_link.oculus import image, messages
from ods.sonar_link.oculus.framer import fault_of
from ods.sonar_link.oculus.messages import CHECK_WORD, MessageKind


class OculusDecoder(Decoder):
    """Counts `other_messages`, `corrupt_pings` and `garbage_bytes`."""

    name = "Oculus .raw"
    signature = ((0, CHECK_WORD),)
    suffix = ".raw"

    def read(self, path: Path) -> PingSequence:
        """Read a recording. Raises PingFileError."""
        data = memory_map(path)
        losses: Counter[str] = Counter()
        found: list[int] = []
        for offset in _results(data, losses):
            try:
                _ping(data, offset, 0)
            except ValueError:
                losses["corrupt_pings"] += 1
            else:
                found.append(offset)
        if not found:
            raise PingFileError(f"{path}: no whole simple ping result in it")
        pings = LazyPings(len(found), lambda index: _ping(data, found[index], index))
        return PingSequence(pings, timed=False, losses=losses)


def _results(data: mmap, losses: Counter[str]) -> Iterator[int]:
    """Yield the offset of each whole simple ping result; count all else."""
    offset = 0
    while offset < len(data):
        fault = fault_of(data, offset)
        header = messages.unpack_header(data, offset) if fault == "" else None
        if header is None or offset + header.size > len(data):
            losses["corrupt_pings"] += fault == "bad_ping"
            found = data.find(CHECK_WORD, offset + 1)
            following = found if found >= 0 else len(data)
            losses["garbage_bytes"] += following - offset
        else:
            following = offset + header.size
            if header.kind == MessageKind.PING:
                yield offset
            else:
                losses["other_messages"] += 1
        offset = following


def _ping(data: mmap, offset: int, index: int) -> Ping:
    """Decode one message. Raises ValueError when its numbers do not fit each other."""
    result = messages.decode_ping_result(data, offset)
    frame, geometry = image.amplitudes_of(result, data, offset), image.geometry_of(result, data, offset)
    return recorded_ping(frame, geometry, index, ping_number=result.ping_number)
