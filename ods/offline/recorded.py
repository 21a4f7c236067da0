"""Messages of a recording of `ods record`, in the form of files of pings."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import msgspec

from ods.base.errors import one_line
from ods.base.files.in_file import opened
from ods.base.files.lazy_sequence import LazySequence, UnreadableItemError, place_after
from ods.messages import Ping, Pose, Truth
from ods.recording.errors import RecordingError
from ods.recording.mcap.framing import MAGIC
from ods.recording.mcap.index import Chunks, Place, Places, places_of
from ods.recording.mcap.reader import Recording, open_recording
from ods.recording.mcap.topics import decoded
from ods.sonar_link.files.fan_image import FanGeometry
from ods.sonar_link.files.opening import open_pings
from ods.sonar_link.files.ping_sequence import PingSequence

MessageT = TypeVar("MessageT", bound=msgspec.Struct)
TOPICS: dict[type[msgspec.Struct], str] = {Ping: "ping", Pose: "pose", Truth: "truth"}


def is_recording(path: Path) -> bool:
    """Return whether a path is a recording of `ods record`, or a folder of its segments."""
    try:
        with opened(path) as file:
            return file.read(len(MAGIC)) == MAGIC
    except IsADirectoryError:
        return True
    except OSError:
        return False  # which reading it will say better


class RecordedMessages(LazySequence[MessageT]):
    """The messages of one kind in a recording, each read when it is asked for. Counts bad ones in `losses`, once."""

    def __init__(
        self, recording: Recording, kind: type[MessageT], places: Places | list[Place], chunks: Chunks
    ) -> None:
        self.recording = recording
        self._kind, self._places, self._chunks = kind, places, chunks
        self._bad: set[int] = set()

    def __len__(self) -> int:
        return len(self._places)

    def item(self, place: int) -> MessageT:
        """Read one. Raises UnreadableItemError."""
        topic = TOPICS[self._kind]
        try:
            message = decoded(topic, self._chunks.message(self._places[place]))
            if isinstance(message, self._kind):
                return message
            raise ValueError(f"no {topic}")
        except (ValueError, RecordingError) as error:
            if place not in self._bad:
                self._bad.add(place)
                self.recording.losses[f"bad_{topic}"] += 1
            raise UnreadableItemError(f"{topic} {place}: {one_line(error)}") from error

    def readable(self) -> "RecordedMessages[MessageT]":
        """Return those that can be read, which reads all once."""
        good = [number for number in range(len(self)) if self._is_readable(number)]
        if len(good) == len(self):
            return self
        places = [self._places[number] for number in good]
        return RecordedMessages(self.recording, self._kind, places, self._chunks)

    def _is_readable(self, number: int) -> bool:
        try:
            self.item(number)
        except UnreadableItemError:
            return False
        return True


class Indexed:
    """A recording in which each message can be read by itself: opening it reads heads of records only."""

    def __init__(self, recording: Recording) -> None:
        """Raises RecordingError."""
        places = places_of(recording, TOPICS.values())
        chunks = Chunks(recording.segments)
        self.losses = recording.losses
        self.pings = RecordedMessages(recording, Ping, places["ping"], chunks)
        self.poses = RecordedMessages(recording, Pose, places["pose"], chunks)
        """In the order in which they were received."""
        self.truths = RecordedMessages(recording, Truth, places["truth"], chunks)


class TruthsByNumber(Mapping[int, Truth]):
    """The truth of pings, found by their increasing numbers."""

    def __init__(self, truths: Sequence[Truth]) -> None:
        self._truths = truths
        self._all: dict[int, Truth] | None = None

    def __len__(self) -> int:
        return len(self._truths if self._all is None else self._all)

    def __iter__(self) -> Iterator[int]:
        if self._all is None:
            self._all = {truth.ping_number: truth for truth in self._truths}
        return iter(self._all)

    def __getitem__(self, number: int) -> Truth:
        """Return that of a ping. Raises KeyError."""
        if self._all is not None:
            return self._all[number]
        place = place_after(self._truths, number, lambda truth: truth.ping_number)
        for truth in self._truths[max(0, place - 1) : place]:
            if truth.ping_number == number:
                return truth
        raise KeyError(number)


def pings_of(path: Path, fan: FanGeometry | None = None) -> PingSequence:
    """Open a recording of pings of any format, those of `ods record` too. Raises OdsError, one line."""
    if is_recording(path):
        recorded = Indexed(open_recording(path))
        return PingSequence(recorded.pings.readable(), losses=recorded.losses)
    return open_pings(path, fan)
