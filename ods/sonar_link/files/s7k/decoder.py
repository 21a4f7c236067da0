"""Recordings in the 7k Data Format, .s7k: the same records as on the wire, one after another."""

from collections import Counter
from pathlib import Path

from ods.base.files.in_file import opened
from ods.messages import Ping
from ods.sonar_link.files.decoder import Decoder
from ods.sonar_link.files.ping_sequence import PingFileError, PingSequence
from ods.sonar_link.s7k import drf
from ods.sonar_link.s7k.assembler import Assembler
from ods.sonar_link.s7k.drf import S7kRecord
from ods.sonar_link.s7k.framer import RecordFramer
from ods.sonar_link.s7k.records import decode

CHUNK_BYTES = 1024 * 1024
LONGEST_RECORD_BYTES = 64 * 1024 * 1024


class S7kDecoder(Decoder):
    """Counts everything in a recording that is no ping."""

    name = ".s7k"
    signature = ((drf.SYNC_AT, drf.SYNC_WORD),)
    suffix = ".s7k"

    def read(self, path: Path) -> PingSequence:
        """Read a recording. Raises PingFileError."""
        counters: Counter[str] = Counter()
        try:
            pings = _pings(path, counters)
        except OSError as error:
            raise PingFileError(f"{path}: {error.strerror}") from error
        if not pings:
            told = ", ".join(f"{name} {count}" for name, count in sorted(counters.items()))
            raise PingFileError(f"{path}: no ping in it ({told})")
        del counters["pings"], counters["records"]
        return PingSequence(pings, timed=not counters["no_device_time"], losses=+counters)


def _pings(path: Path, counters: Counter[str]) -> list[Ping]:
    framer = RecordFramer(LONGEST_RECORD_BYTES, counters)
    assembler = Assembler(counters=counters)
    pings: list[Ping] = []
    with opened(path) as file:
        while chunk := file.read(CHUNK_BYTES):
            pings += _assembled(assembler, framer.feed(chunk))
    return pings + _assembled(assembler, framer.flush())


def _assembled(assembler: Assembler, found: list[S7kRecord]) -> list[Ping]:
    return [ping for record in found if (ping := assembler.feed(record, decode(record))) is not None]
