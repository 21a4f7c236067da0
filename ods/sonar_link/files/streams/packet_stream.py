"""Recordings of a sonar's raw network stream: packets that begin with a sync word, some of them images."""

from abc import abstractmethod
from collections import Counter
from collections.abc import Iterator
from mmap import mmap
from pathlib import Path
from typing import ClassVar, NamedTuple

from ods.messages import Ping
from ods.sonar_link.files.decoder import Decoder
from ods.sonar_link.files.mapped_file import memory_map
from ods.sonar_link.files.ping_sequence import LazyPings, PingFileError, PingSequence
from ods.sonar_link.sync_framer import MAX_PACKET_BYTES, ChecksumBudget


class Found(NamedTuple):
    """Packet found at a position of the file."""

    size: int
    """Bytes of the packet; 0: there is none."""
    corrupt: bool = False
    """There is a packet, but it cannot be used."""
    is_image: bool = False


class PacketStreamDecoder(Decoder):
    """Counts `other_messages`, `corrupt_pings` and `garbage_bytes`."""

    sync: ClassVar[bytes]
    image_called: ClassVar[str]
    timed: ClassVar[bool]

    def read(self, path: Path) -> PingSequence:
        """Read a recording. Raises PingFileError."""
        data = memory_map(path)
        losses: Counter[str] = Counter()
        found: list[int] = []
        for offset in self._images(data, losses):
            try:
                self._ping(data, offset, 0)
            except ValueError:
                losses["corrupt_pings"] += 1
            else:
                found.append(offset)
        if not found:
            raise PingFileError(f"{path}: no complete {self.image_called} in it")
        pings = LazyPings(len(found), lambda index: self._ping(data, found[index], index))
        return PingSequence(pings, timed=self.timed, losses=+losses)

    def _images(self, data: mmap, losses: "Counter[str]") -> Iterator[int]:
        """Yield the offset of each whole image; count all else."""
        for found, offset in self._packets(data, losses):
            if found.is_image:
                yield offset
            else:
                losses["other_messages"] += 1

    def _packets(self, data: mmap, losses: "Counter[str]") -> Iterator[tuple[Found, int]]:
        offset, budget = 0, ChecksumBudget(MAX_PACKET_BYTES)
        while offset < len(data):
            found = self._look(data, offset, budget)
            if found.size:
                yield found, offset
                step = found.size
            else:
                losses["corrupt_pings"] += found.corrupt
                following = data.find(self.sync, offset + 1)
                step = (following if following >= 0 else len(data)) - offset
                losses["garbage_bytes"] += step
            budget.earn(step)
            offset += step

    @abstractmethod
    def _look(self, data: mmap, offset: int, budget: ChecksumBudget) -> Found:
        """Return what begins at an offset; `budget` bounds the checksums that are computed."""

    @abstractmethod
    def _ping(self, data: mmap, offset: int, index: int) -> Ping:
        """Decode one image. Raises ValueError when its numbers do not fit each other."""
