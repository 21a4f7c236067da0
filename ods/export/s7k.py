"""A .s7k file for 7k software, by the writer of `ods record --s7k`."""

from collections import Counter
from pathlib import Path

import msgspec

from ods.base.geodesy import LocalFrame
from ods.messages import ObstacleList, Ping, Pose
from ods.recording.record_s7k import WRITTEN
from ods.recording.s7k import RECORDED_DEVICES, Recorder
from ods.sonar_link.files.s7k.writer import S7kWriter


class S7kFile:
    """Writes pings, contacts and poses into a new file; their times go on evenly from the UTC of the first message."""

    def __init__(self, path: Path, frame: LocalFrame) -> None:
        """Raises OSError."""
        self._path, self._frame = path, frame
        self._file = path.open("xb", buffering=0)
        self._written: tuple[S7kWriter, Recorder] | None = None

    @property
    def losses(self) -> "Counter[str]":
        """The counters of docs/counters/README.md that count losses."""
        counters = self._written[1].counters if self._written else {}
        return Counter({name: count for name, count in counters.items() if name not in WRITTEN})

    def take(self, stamp_ns: int, message: msgspec.Struct) -> None:
        """Write a message's records. Raises OSError."""
        if not isinstance(message, Ping | ObstacleList | Pose):
            return
        if self._written is None:
            writer = S7kWriter(self._file, self._path.name, stamp_ns, RECORDED_DEVICES)
            self._written = writer, Recorder(writer, self._frame)
        self._written[1].take(message)

    def close(self) -> None:
        """Raises OSError."""
        with self._file:
            if self._written:
                self._written[0].close()
