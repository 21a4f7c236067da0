"""Messages by their places are those that are read one after the other: of whole, torn, foreign and hostile files."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import msgspec
import pytest
from hypothesis import given, settings, strategies as st
from mcap.records import Channel, Chunk, Header, Message, MessageIndex, Schema
from mcap.writer import CompressionType, IndexType, Writer

from ods.messages import Truth
from ods.offline.recorded import Indexed, TruthsByNumber, pings_of
from ods.recording.errors import RecordingError
from ods.recording.mcap.framing import MAGIC, encoded
from ods.recording.mcap.index import Chunks, places_of
from ods.recording.mcap.reader import open_recording
from ods.recording.mcap.segment import Logged, Segment
from tests.recording.mcap_samples import OFFSET_NS, mission, pose, small_ping, write_segment

TOPICS = ("ping", "pose", "obstacles")


def one_by_one(path: Path) -> dict[str, list[bytes]]:
    found: dict[str, list[bytes]] = {topic: [] for topic in TOPICS}
    for message in open_recording(path).messages(TOPICS):
        found[message.topic].append(message.data)
    return found


def by_places(path: Path) -> dict[str, list[bytes]]:
    """Read backwards, so that no order helps."""
    recording = open_recording(path)
    chunks = Chunks(recording.segments)
    places = places_of(recording, TOPICS)
    return {
        topic: [chunks.message(found[number]) for number in reversed(range(len(found)))][::-1]
        for topic, found in places.items()
    }


@pytest.mark.parametrize("finish", [True, False])
def test_a_segment(tmp_path: Path, finish: bool) -> None:
    path = write_segment(tmp_path / "a.mcap", mission(6), finish=finish)
    read = by_places(path)
    assert read == one_by_one(path)
    assert [len(read[topic]) for topic in TOPICS] == [6, 90, 6]


def test_a_folder(tmp_path: Path) -> None:
    samples = mission(6)
    write_segment(tmp_path / "00000.mcap", samples[:54], finish=False)
    write_segment(tmp_path / "00001.mcap", samples[54:])
    assert by_places(tmp_path) == one_by_one(tmp_path)


def test_a_file_that_is_cut_off_anywhere(tmp_path: Path) -> None:
    whole = write_segment(tmp_path / "a.mcap", mission(3, poses_a_ping=3), finish=False).read_bytes()
    cut = tmp_path / "cut.mcap"
    for length in range(len(whole) - 1800, len(whole), 29):
        cut.write_bytes(whole[:length])
        assert by_places(cut) == one_by_one(cut)


@pytest.mark.parametrize("compression", [CompressionType.ZSTD, CompressionType.NONE])
@pytest.mark.parametrize("index", [IndexType.ALL, IndexType.NONE])
def test_a_file_of_another_writer(tmp_path: Path, compression: CompressionType, index: IndexType) -> None:
    """It tells its channels in the chunks, of which each holds many messages in no order, or tells no index at all."""
    path = tmp_path / "a.mcap"
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=4000, compression=compression, index_types=index)
        writer.start("ods")
        schema = writer.register_schema("any", "jsonschema", b"{}")
        channels = {topic: writer.register_channel(topic, "msgpack", schema) for topic in ("pose", "ping", "other")}
        for topic, log_ns, message in mission(5):
            log = log_ns - (3_000_000 if topic == "ping" else 0)
            writer.add_message(channels.get(topic, channels["other"]), log, msgspec.msgpack.encode(message), log)
        writer.finish()
    assert by_places(path) == one_by_one(path)
    assert len(by_places(path)["ping"]) == 5


HEAD = MAGIC + encoded(Header("ods", ""), Schema(1, b"", "", "x"), Channel(1, "ping", "msgpack", {}, 1))
MESSAGE = encoded(Message(1, 5, b"\x80", 5, 0))
CHUNK = encoded(Chunk("", MESSAGE, 0, 0, 0, len(MESSAGE)))
LIES = {
    "beyond the chunk": [MessageIndex(1, [(5, 10**6)])],
    "beyond all numbers": [MessageIndex(1, [(5, 2**64 - 1)])],
    "amid the message": [MessageIndex(1, [(5, 4)])],
    "more than there can be": [MessageIndex(1, [(5, 0)] * 1000)],
    "another channel": [MessageIndex(7, [(5, 0)])],
}


@pytest.mark.parametrize("what", LIES)
def test_an_index_that_lies_gives_a_message_or_one_line(tmp_path: Path, what: str) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(HEAD + CHUNK + encoded(*LIES[what]) + MESSAGE)
    recording = open_recording(path)
    chunks, places = Chunks(recording.segments), places_of(recording, ["ping"])["ping"]
    assert len(places) == 2
    assert chunks.message(places[1]) == b"\x80"
    if what in ("more than there can be", "another channel"):
        assert chunks.message(places[0]) == b"\x80"
    else:
        with pytest.raises(RecordingError, match=r"a\.mcap: the index points to a message"):
            chunks.message(places[0])


def test_a_file_that_changes_gives_one_line(tmp_path: Path) -> None:
    path = write_segment(tmp_path / "a.mcap", mission(2))
    recorded = Indexed(open_recording(path))
    path.write_bytes(path.read_bytes()[:2000])
    assert list(recorded.pings) == []
    assert recorded.losses == {"bad_ping": 2}


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_flipped_bytes_never_raise_anything_else(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    folder = tmp_path_factory.getbasetemp()
    path = folder / "whole index.mcap"
    if not path.exists():
        write_segment(path, mission(3, poses_a_ping=3), finish=False)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(1, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    damaged = folder / "damaged index.mcap"
    damaged.write_bytes(content)
    try:
        recorded = Indexed(open_recording(damaged))
    except RecordingError:
        return
    for messages in (recorded.pings, recorded.poses, recorded.truths):
        assert len(list(messages)) <= len(messages)


def damaged_mission(path: Path, bad: Iterable[int]) -> Path:
    """Write pings of which some are none."""
    segment = Segment(path, OFFSET_NS, {"ods": {"utc_offset_ns": str(OFFSET_NS)}})
    for number in range(6):
        ping: Any = {"no": "ping"} if number in bad else small_ping(number, 1000 + number)
        segment.write([Logged("pose", OFFSET_NS + number, msgspec.msgpack.encode(pose(number, 1000 + number)))])
        segment.write([Logged("ping", OFFSET_NS + number, msgspec.msgpack.encode(ping))])
        segment.close_chunk()
    segment.finish()
    return path


def test_bad_messages_are_left_out_and_counted_once(tmp_path: Path) -> None:
    path = damaged_mission(tmp_path / "a.mcap", bad=(2, 5))
    recorded = Indexed(open_recording(path))
    assert len(recorded.pings) == 6
    assert [ping.seq for ping in recorded.pings] == [0, 1, 3, 4]
    assert [ping.seq for ping in recorded.pings.readable()] == [0, 1, 3, 4]
    assert recorded.losses == {"bad_ping": 2}
    sequence = pings_of(path)
    assert [sequence.pings[place].seq for place in (3, 0, 2)] == [4, 0, 3]


def test_truths_are_found_by_the_numbers_of_pings() -> None:
    zero = (0.0, 0.0, 0.0)
    truths = [Truth(number, 5, 6, zero, (1.0, *zero), []) for number in (2, 3, 7, 9)]
    by_number = TruthsByNumber(truths)
    for _ in range(2):  # then those that were kept
        assert {number: by_number.get(number) for number in range(11)} == {
            number: next((truth for truth in truths if truth.ping_number == number), None) for number in range(11)
        }
        assert dict(by_number) == {truth.ping_number: truth for truth in truths}
