"""Recordings in the 7k Data Format, .s7k: the same records as on the wire, one after another."""

from collections import Counter
from collections.abc import Iterable
from pathlib import Path

from ods.messages import Ping
from ods.sonar_link import s7k
from ods.sonar_link.assembler import Assembler
from ods.sonar_link.files.ping_sequence import PingFileError, PingSequence
from ods.sonar_link.files.s7k_writer import S7kWriter
from ods.sonar_link.framer import Framer

CHUNK_BYTES = 1024 * 1024
MAX_RECORD_BYTES = 64 * 1024 * 1024


def read_s7k(path: Path) -> PingSequence:
    """Read a recording; everything in it that is no ping is counted in `losses`. Raises PingFileError."""
    counters: Counter[str] = Counter()
    framer = Framer(MAX_RECORD_BYTES, counters)
    assembler = Assembler(counters=counters)
    pings: list[Ping] = []
    try:
        with path.open("rb") as file:
            while chunk := file.read(CHUNK_BYTES):
                pings += filter(None, map(assembler.feed, framer.feed(chunk)))
    except OSError as error:
        raise PingFileError(f"{path}: {error.strerror}") from error
    pings += filter(None, map(assembler.feed, framer.flush()))
    if not pings:
        told = ", ".join(f"{name} {count}" for name, count in sorted(counters.items()))
        raise PingFileError(f"{path}: no ping in it ({told})")
    del counters["pings"], counters["records"]
    return PingSequence(pings, timed=not counters["no_device_time"], losses=+counters)


def write_s7k(path: Path, pings: Iterable[Ping]) -> None:
    """Write pings of any geometry. Raises ValueError when one cannot be carried by the format, OSError on the disk."""
    with path.open("wb", buffering=0) as file:
        writer: S7kWriter | None = None
        for ping in pings:
            writer = writer or S7kWriter(file, path.name, ping.utc_ns)
            writer.write(s7k.encode_ping(ping, recorded=True))
        if writer is not None:
            writer.close()
