"""What a format gets, message by message."""

from collections import Counter
from typing import Protocol

import msgspec


class Sink(Protocol):
    """A file of one format, being written."""

    @property
    def losses(self) -> "Counter[str]":
        """What could not be written, in a few words, and how often."""

    def take(self, stamp_ns: int, message: msgspec.Struct) -> None:
        """Write a message; `stamp_ns`: the instant that it is about, UTC. Raises OSError, UnfitMessageError."""

    def close(self) -> None:
        """Write what is still held, and close. Raises OSError."""


class UnfitMessageError(Exception):
    """A message cannot be written in this format; the text says why in a few words."""
