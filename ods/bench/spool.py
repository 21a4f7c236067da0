"""Record of a run of any length, on the disk: in memory it would be 290 MB an hour."""

import os
import tempfile
from array import array
from pathlib import Path
from typing import Any, TypeVar

import msgspec

from ods.base.files.lazy_sequence import LazySequence

ItemT = TypeVar("ItemT")


class Spool(LazySequence[ItemT]):
    """Messages in the order in which they were appended; in memory there are 8 bytes of each."""

    def __init__(self, kind: Any, folder: Path | None = None) -> None:
        """`kind`: the items' type, as msgspec takes it; `folder`: where a file without a name has room."""
        self._file = tempfile.TemporaryFile(dir=folder, buffering=0)  # noqa: SIM115  as long as the spool
        self._ends = array("Q", [0])
        self._encoder = msgspec.msgpack.Encoder()
        self._decoder: msgspec.msgpack.Decoder[ItemT] = msgspec.msgpack.Decoder(kind)

    def __len__(self) -> int:
        return len(self._ends) - 1

    def append(self, item: ItemT) -> None:
        """Keep one more. Raises OSError."""
        content = self._encoder.encode(item)
        os.pwrite(self._file.fileno(), content, self._ends[-1])
        self._ends.append(self._ends[-1] + len(content))

    def item(self, place: int) -> ItemT:
        """Read one. Raises OSError."""
        start, end = self._ends[place], self._ends[place + 1]
        return self._decoder.decode(os.pread(self._file.fileno(), end - start, start))
