"""The results of a campaign: one JSON line per mission and arm, in order, so that a stopped campaign can continue."""

import os
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import BinaryIO

import msgspec

from ods.base.errors import OdsError, reason_of
from ods.base.files.in_file import MOST_BYTES, content_of
from ods.missions.outcome import Outcome

NAME = "missions.jsonl"


class Journal:
    """A file that begins with the settings its results depend on; a line left incomplete by a stopped campaign is
    removed."""

    def __init__(self, folder: Path, depends_on: Mapping[str, object]) -> None:
        """`depends_on`: what the results are of. Raises OdsError: unwritable, or of something else."""
        self._path = folder / NAME
        head = msgspec.json.encode(depends_on, enc_hook=str) + b"\n"
        self.done: list[Outcome] = []
        """Results that were there already, in order."""
        try:
            folder.mkdir(parents=True, exist_ok=True)
            kept = self._kept(head) if self._path.exists() else b""
            self._file: BinaryIO = self._path.open("r+b" if kept else "wb")
            self._file.write(kept or head)
            self._file.truncate()
            self._file.flush()
        except OSError as error:
            raise OdsError(f"{self._path}: {reason_of(error)}") from error

    def _kept(self, head: bytes) -> bytes:
        content = content_of(self._path, MOST_BYTES)
        whole = content[: content.rfind(b"\n") + 1]
        if not whole:
            return b""
        if not whole.startswith(head):
            raise OdsError(f"{self._path}: belongs to another campaign: give another --out, or remove it")
        try:
            self.done = list(_outcomes(whole[len(head) :]))
        except msgspec.MsgspecError as error:
            raise OdsError(f"{self._path}: {error}: remove it to start again") from error
        return whole

    def add(self, outcome: Outcome) -> None:
        """Write the next result. Raises OdsError."""
        try:
            self._file.write(msgspec.json.encode(outcome) + b"\n")
            self._file.flush()
        except OSError as error:
            raise OdsError(f"{self._path}: {reason_of(error)}") from error
        self.done.append(outcome)

    def close(self) -> None:
        """Let the disk have it."""
        os.fsync(self._file.fileno())
        self._file.close()


def _outcomes(lines: bytes) -> Iterator[Outcome]:
    decoder = msgspec.json.Decoder(Outcome)
    return map(decoder.decode, lines.splitlines())


def file_name(name: str) -> str:
    """Return a folder's name for a variant's."""
    return re.sub(r"[^a-zA-Z0-9.]+", "-", name).strip("-.") or "variant"
