"""Messages of a recording of `ods record`, as files of pings tell theirs."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TypeVar, overload

import msgspec

from ods.messages import Ping, Pose, Truth
from ods.recording.mcap.framing import MAGIC
from ods.recording.mcap.reader import Recording, open_recording
from ods.sonar_link.files.fan_image import FanGeometry
from ods.sonar_link.files.opening import open_pings
from ods.sonar_link.files.ping_sequence import PingSequence

MessageT = TypeVar("MessageT", bound=msgspec.Struct)
TOPICS: dict[type[msgspec.Struct], str] = {Ping: "ping", Pose: "pose", Truth: "truth"}


def is_recording(path: Path) -> bool:
    """Tell whether a path is a recording of `ods record`, or a folder of its segments."""
    try:
        with path.open("rb") as file:
            return file.read(len(MAGIC)) == MAGIC
    except IsADirectoryError:
        return True
    except OSError:
        return False  # which reading it will say better


def decoded_of(recording: Recording, kind: type[MessageT]) -> Iterator[MessageT]:
    """Yield the messages of one kind; what is none is counted among the recording's losses. Raises RecordingError."""
    topic = TOPICS[kind]
    for recorded in recording.messages([topic]):
        try:
            message = recorded.message()
        except ValueError:
            recording.losses[f"bad_{topic}"] += 1
            continue
        if isinstance(message, kind):
            yield message


class RecordedPings(Sequence[Ping]):
    """The pings of a recording. They are read one after the other: going back begins anew."""

    def __init__(self, recording: Recording) -> None:
        """Count them, which reads the file once. Raises RecordingError."""
        self._recording = recording
        self._count = sum(1 for _ in decoded_of(recording, Ping))
        self._rewind()

    def _rewind(self) -> None:
        self._pings, self._next = decoded_of(self._recording, Ping), 0
        self._newest: tuple[int, Ping] | None = None

    def __len__(self) -> int:
        return self._count

    @overload
    def __getitem__(self, index: int) -> Ping: ...

    @overload
    def __getitem__(self, index: slice) -> list[Ping]: ...

    def __getitem__(self, index: int | slice) -> Ping | list[Ping]:
        """Return one ping or a list of some. Raises IndexError, RecordingError."""
        if isinstance(index, slice):
            return [self[place] for place in range(self._count)[index]]
        place = range(self._count)[index]
        if self._newest is not None and self._newest[0] == place:
            return self._newest[1]
        if place < self._next:
            self._rewind()
        for ping in self._pings:
            self._next += 1
            if self._next > place:
                self._newest = place, ping
                return ping
        raise IndexError(index)


def pings_of(path: Path, fan: FanGeometry | None = None) -> PingSequence:
    """Open a recording of pings of any format, those of `ods record` too. Raises OdsError, one line."""
    if is_recording(path):
        recorded = open_recording(path)
        return PingSequence(RecordedPings(recorded), losses=recorded.losses)
    return open_pings(path, fan)
