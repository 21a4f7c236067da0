"""What a format of recordings is: how a file of it is known, and how it is read. A plug-in adds one:

@decoder
class SketchDecoder(Decoder):
    ...
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import ClassVar, TypeVar

from ods.base.plugins import PluginGroup, add
from ods.sonar_link.files.ping_sequence import PingSequence

PLUGINS = PluginGroup("recordings.plugins", "ods.recordings")
"""Where decoders of the user's own are named."""
START_BYTES = 16
"""Number of bytes at a file's beginning that show its format."""


class Decoder(ABC):
    """Reads recordings of one format."""

    name: ClassVar[str]
    """What users call the format."""
    signature: ClassVar[tuple[tuple[int, bytes], ...]]
    """Parts that every such file has within its first START_BYTES: where each stands, and its bytes. One at least."""
    suffix: ClassVar[str | None] = None
    """Lower case; files without any known signature are taken for this format by this ending. None: never."""

    def recognizes(self, start: bytes) -> bool:
        """Return whether a file that begins with these START_BYTES is of this format."""
        return all(start.startswith(part, place) for place, part in self.signature)

    @abstractmethod
    def read(self, path: Path) -> PingSequence:
        """Read a recording; what it holds and the pings do not is counted in `losses`. Raises PingFileError."""


PLUGGED_IN: dict[str, Callable[[], Decoder]] = {}
"""Decoders of the user's own, by name."""

DecoderT = TypeVar("DecoderT", bound=Decoder)


def decoder(kind: type[DecoderT]) -> type[DecoderT]:
    """Register the decorated class, which is made without arguments. Raises PluginError when its name is taken."""
    make: Callable[[], Decoder] = kind
    add(PLUGGED_IN, "decoder", kind.name, make)
    return kind
