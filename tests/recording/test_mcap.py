"""Recordings survive the file: read back by ods and by the mcap library; torn, foreign and hostile ones."""

import errno
import struct
import subprocess
import sys
import zlib
from collections import Counter
from pathlib import Path

import msgspec
import pytest
import zstandard
from hypothesis import given, settings, strategies as st
from mcap.reader import make_reader
from mcap.records import Channel, Chunk, Header, Message, Schema
from mcap.writer import Writer

from ods import __version__
from ods.recording.errors import RecordingError
from ods.recording.inbox import Received
from ods.recording.mcap.framing import LONGEST_MESSAGE_BYTES, MAGIC, RECORD, encoded
from ods.recording.mcap.reader import open_recording
from ods.recording.mcap.session import Session
from tests.recording.mcap_samples import OFFSET_NS, Sample, mission, write_segment


def _read(path: Path) -> list[Sample]:
    return [(each.topic, each.log_ns, each.message()) for each in open_recording(path).messages()]


@pytest.mark.parametrize("finish", [True, False])
def test_what_is_written_is_read(tmp_path: Path, finish: bool) -> None:
    """A recorder that was killed leaves messages that are in no chunk yet; they are read as well."""
    samples = mission(5)
    attachments = {"config.toml": b"[bus]\n", "map.sqlite": bytes(range(256)) * 100}
    path = write_segment(
        tmp_path / "a.mcap", samples, metadata={"version": "9.9"}, attachments=attachments, finish=finish
    )
    recording = open_recording(path)
    assert _read(path) == samples
    assert recording.metadata["ods"] == {"utc_offset_ns": str(OFFSET_NS), "version": "9.9"}
    assert recording.attachments == attachments
    poses = list(recording.messages(["pose"]))
    assert [each.topic for each in poses] == ["pose"] * 75
    assert poses[0].utc_ns == poses[0].log_ns + OFFSET_NS
    assert poses[0].data == msgspec.msgpack.encode(samples[0][2])
    assert recording.losses == Counter()


def test_the_mcap_library_reads_the_same_by_the_index(tmp_path: Path) -> None:
    samples = mission(5)
    path = write_segment(tmp_path / "a.mcap", samples, attachments={"config.toml": b"x"})
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        assert summary.statistics.message_count == len(samples)
        assert summary.statistics.chunk_count == 6 == len(summary.chunk_indexes)
        assert [index.name for index in summary.attachment_indexes] == ["config.toml"]
        read = list(reader.iter_messages())
        assert [(c.topic, m.log_time, m.data) for _, c, m in read] == [
            (topic, log_ns + OFFSET_NS, msgspec.msgpack.encode(message)) for topic, log_ns, message in samples
        ]
        schema, channel, message = read[0]
        assert schema is not None
        assert (schema.name, schema.encoding, channel.message_encoding) == ("Pose", "jsonschema", "msgpack")
        assert message.publish_time == samples[0][1] - 1_000_000 + OFFSET_NS
        assert message.sequence == 0
        late = list(reader.iter_messages(["ping"], starting_at=samples[-1][1] + OFFSET_NS - 500_000))
        assert [m.sequence for _, _, m in late] == [4]


def test_a_file_written_again_by_another_program_has_the_same_times(tmp_path: Path) -> None:
    """The format leaves open where metadata stand: here behind all messages, as the offset of their times does."""
    samples = mission(5)
    path, again = write_segment(tmp_path / "a.mcap", samples), tmp_path / "again.mcap"
    with path.open("rb") as file, again.open("wb") as out:
        reader, writer = make_reader(file), Writer(out, use_chunking=False)
        writer.start(reader.get_header().profile, "another program")
        channels: dict[str, int] = {}
        for _, channel, message in reader.iter_messages():
            if channel.topic not in channels:
                channels[channel.topic] = writer.register_channel(channel.topic, channel.message_encoding, 0)
            writer.add_message(channels[channel.topic], message.log_time, message.data, message.publish_time)
        for metadata in reader.iter_metadata():
            writer.add_metadata(metadata.name, metadata.metadata)
        writer.finish()
    assert _read(again) == samples


def test_a_message_longer_than_any_reader_takes_is_counted_and_left_out(tmp_path: Path) -> None:
    session = Session(tmp_path, {"utc_offset_ns": str(OFFSET_NS)}, 10**12)
    short = msgspec.msgpack.encode({"seq": 1})
    long = Received("raw", 2, bytes(LONGEST_MESSAGE_BYTES + 1))
    session.write([Received("pose", 1, short), long, Received("pose", 3, short)])
    session.finish()
    assert session.left_out == 1
    assert [(message.topic, message.log_ns) for message in open_recording(tmp_path).messages()] == [
        ("pose", 1),
        ("pose", 3),
    ]


def test_a_folder_is_read_in_order_and_a_broken_file_in_it_is_counted(tmp_path: Path) -> None:
    samples = mission(6)
    write_segment(tmp_path / "00001.mcap", samples[54:])
    write_segment(tmp_path / "00000.mcap", samples[:54], finish=False)
    (tmp_path / "00002.mcap").write_bytes(b"rubbish")
    assert _read(tmp_path) == samples
    assert open_recording(tmp_path).losses == {"unreadable_segments": 1}


def test_a_file_cut_off_anywhere_gives_its_whole_messages(tmp_path: Path) -> None:
    samples = mission(3, poses_a_ping=3)
    whole = write_segment(tmp_path / "a.mcap", samples, finish=False).read_bytes()
    cut = tmp_path / "cut.mcap"
    counts = []
    for length in range(len(whole) - 1500, len(whole), 13):
        cut.write_bytes(whole[:length])
        recording = open_recording(cut)
        read = [(each.topic, each.log_ns, each.message()) for each in recording.messages()]
        assert read == samples[: len(read)]
        assert recording.losses.keys() <= {"torn"}
        counts.append(len(read))
    assert counts == sorted(counts)
    assert counts[0] < counts[-1] == len(samples) - 1


def test_a_kill_between_the_chunk_and_the_cut_behind_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    samples = mission(1, 15, samples=2000)[:16]
    with monkeypatch.context() as patch:
        patch.setattr("os.ftruncate", lambda fd, size: None)
        path = write_segment(tmp_path / "a.mcap", samples, finish=False)
    recording = open_recording(path)
    assert [(each.topic, each.log_ns, each.message()) for each in recording.messages()] == samples
    assert recording.losses == Counter()


@pytest.mark.parametrize(
    ("content", "says"),
    [
        (b"", "the file is empty"),
        (MAGIC.replace(b"0", b"1") + b"more", "an MCAP file of another version than 0"),
        (b"rubbish" * 100, "not an MCAP file"),
        (MAGIC, "not a recording of ODS"),
        (MAGIC + encoded(Header("ros2", "somebody")), "not a recording of ODS"),
    ],
)
def test_a_foreign_file_is_one_line(tmp_path: Path, content: bytes, says: str) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(content)
    with pytest.raises(RecordingError, match=says):
        open_recording(path)


@pytest.mark.parametrize(("version", "newer"), [("99.0.0", True), ("0.4.0", False), ("", False), (__version__, False)])
def test_a_recording_of_a_newer_version_is_read_with_one_warning(
    tmp_path: Path, caplog: pytest.LogCaptureFixture, version: str, newer: bool
) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(HEAD.replace(encoded(Header("ods", "x")), encoded(Header("ods", f"ods {version}"))))
    assert list(open_recording(path).messages()) == []
    said = f"{path}: recorded by ods {version}: what this one, {__version__}, does not know is left out"
    assert caplog.messages == [said] * newer


def test_no_file_and_an_empty_folder_are_one_line(tmp_path: Path) -> None:
    with pytest.raises(RecordingError, match=r"nowhere\.mcap: No such file"):
        open_recording(tmp_path / "nowhere.mcap")
    with pytest.raises(RecordingError, match="no recording in it"):
        open_recording(tmp_path)


HEAD = MAGIC + encoded(Header("ods", "x"), Schema(1, b"{}", "jsonschema", "Pose"), Channel(1, "pose", "msgpack", {}, 1))


def _chunk(records: bytes, size: int | None = None, compression: str = "zstd", checksum: int | None = None) -> bytes:
    packed = zstandard.compress(records) if compression == "zstd" else records
    reported = zlib.crc32(records) if checksum is None else checksum
    return encoded(Chunk(compression, packed, 0, 0, reported, len(records) if size is None else size))


def _bomb() -> bytes:
    """A chunk that would take 4 GB."""
    packed = zstandard.ZstdCompressor().compressobj(size=-1)
    zeros = bytes(1_000_000)
    data = b"".join(packed.compress(zeros) for _ in range(4000)) + packed.flush()
    return encoded(Chunk("zstd", data, 0, 0, 0, 30_000_000))


MESSAGE = encoded(Message(1, 5, b"\x80", 5, 0))
HOSTILE = {
    "a length beyond the file": RECORD.pack(5, 2**62) + b"x",
    "a message shorter than its head": RECORD.pack(5, 3) + b"abc",
    "an unknown channel": encoded(Message(9, 5, b"\x80", 5, 0)),
    "a chunk that tells too little": _chunk(MESSAGE, size=3),
    "a chunk that tells too much": _chunk(MESSAGE, size=2**40),
    "a wrong checksum": _chunk(MESSAGE, checksum=7),
    "an unknown compression": _chunk(MESSAGE, compression="lzma"),
    "a chunk of rubbish": _chunk(b"rubbish" * 9),
    "a chunk in a chunk": _chunk(_chunk(MESSAGE)),
    "no chunk": RECORD.pack(6, 5) + b"12345",
    "no channel": RECORD.pack(4, 9) + b"\xff" * 9,
    "no metadata": RECORD.pack(12, 9) + b"\xff" * 9,
    "no attachment": RECORD.pack(9, 9) + b"\xff" * 9,
}


@pytest.mark.parametrize("what", HOSTILE)
def test_a_hostile_record_is_counted_and_the_next_one_read(tmp_path: Path, what: str) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(HEAD + HOSTILE[what] + MESSAGE)
    recording = open_recording(path)
    read = list(recording.messages())
    assert list(recording.messages(["pose"])) == read  # a second reader, as of replay, loses the same
    assert (recording.metadata, recording.attachments) == ({}, {})
    lost = what == "a length beyond the file"
    assert [each.data for each in read] == [] if lost else [b"\x80"]
    assert recording.losses.pop("segments_without_utc") == 1
    assert recording.losses.total() == (0 if what == "a chunk in a chunk" else 2 if what == "no metadata" else 1)
    for each in read:
        with pytest.raises(ValueError, match="missing required field"):
            each.message()


READ_ALL = r"""
import re, sys
from pathlib import Path
from ods.recording.mcap.reader import open_recording
from ods.recording.mcap.session import Session
recording = open_recording(Path(sys.argv[1]))
print(sum(len(each.data) for each in recording.messages()), dict(recording.losses), len(recording.attachments))
print(re.search(r"VmHWM:\s+(\d+) kB", Path("/proc/self/status").read_text())[1])
"""


def test_no_file_takes_more_than_200_mb(tmp_path: Path) -> None:
    """Zip bombs, names, attachments and messages as large as they may be, and larger ones; a chunk of tiny messages."""
    path = tmp_path / "a.mcap"
    huge = encoded(Message(1, 5, bytes(31_000_000), 5, 0))
    with path.open("wb") as file:
        for number in range(20):  # 60 kB of file: names of 600 MB
            file.write(
                (HEAD if number == 0 else b"") + _chunk(encoded(Channel(number, "n" * 30_000_000, "msgpack", {}, 1)))
            )
        file.write(_chunk(MESSAGE * 1_000_000))
        file.write(_bomb() + _chunk(huge) + huge)
        file.write(RECORD.pack(9, 40_000_000) + bytes(40_000_000))
        for name in ("a", "b", "c"):
            file.write(RECORD.pack(9, 30_000_029) + bytes(16) + struct.pack("<I1sI", 1, name.encode(), 0))
            file.write(struct.pack("<Q", 29_999_992) + bytes(29_999_992 + 4))
    done = subprocess.run([sys.executable, "-c", READ_ALL, str(path)], capture_output=True, text=True, check=True)
    reported, peak_kb = done.stdout.splitlines()
    print(reported, peak_kb)
    assert reported.startswith("62200000 ")
    assert int(peak_kb) < 200_000


@settings(max_examples=150, deadline=None)
@given(data=st.data())
def test_flipped_and_cut_bytes_never_raise(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    """What is read is of the messages written, or fails to decode; nothing but RecordingError comes out."""
    folder = tmp_path_factory.getbasetemp()
    path = folder / "whole.mcap"
    if not path.exists():
        write_segment(path, mission(3, poses_a_ping=3), attachments={"config.toml": b"x" * 50}, finish=False)
    content = bytearray(path.read_bytes())
    for _ in range(data.draw(st.integers(0, 4))):
        content[data.draw(st.integers(0, len(content) - 1))] ^= 1 << data.draw(st.integers(0, 7))
    damaged = folder / "damaged.mcap"
    damaged.write_bytes(content[: data.draw(st.integers(0, len(content)))])
    try:
        recording = open_recording(damaged)
    except RecordingError:
        return
    for each in recording.messages():
        try:
            each.message()
        except ValueError:
            continue
    assert len(recording.metadata) <= 2


def test_a_full_disk_leaves_whole_messages_and_the_writer_goes_on(tmp_path: Path) -> None:
    """RLIMIT_FSIZE in the place of a full disk; the limit falls into messages, into chunks, and into the end."""
    samples = mission(4, poses_a_ping=4)
    whole = write_segment(tmp_path / "whole.mcap", samples, finish=False).stat().st_size
    code = """
import resource, signal, sys
from pathlib import Path
from ods.recording.mcap.segment import Logged, Segment
from tests.recording.mcap_samples import OFFSET_NS, mission
import msgspec
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
path, limits = Path(sys.argv[1]), [int(word) for word in sys.argv[2:]]
for limit in limits:
    file = path / f"{limit}.mcap"
    segment = Segment(file, OFFSET_NS, {"ods": {"utc_offset_ns": str(OFFSET_NS)}})
    resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY))
    failed = 0
    def patiently(job):
        global failed
        try:
            job()
        except OSError:
            failed += 1
            (path / f"{limit}.full").write_bytes(file.read_bytes()[:limit])
            resource.setrlimit(resource.RLIMIT_FSIZE, (resource.RLIM_INFINITY, resource.RLIM_INFINITY))
            job()
    for topic, log_ns, message in mission(4, poses_a_ping=4):
        logged = Logged(topic, log_ns + OFFSET_NS, msgspec.msgpack.encode(message))
        patiently(lambda: segment.write([logged]))
        if topic == "ping":
            patiently(segment.close_chunk)
    segment.finish()
    assert failed == 1, (limit, failed)
"""
    head = write_segment(tmp_path / "head.mcap", [], finish=False).stat().st_size
    limits = range(head + 7, whole, 97)
    subprocess.run([sys.executable, "-c", code, str(tmp_path), *map(str, limits)], check=True)
    for limit in limits:
        assert _read(tmp_path / f"{limit}.mcap") == samples
        when_full = open_recording(tmp_path / f"{limit}.full")
        read = [(each.topic, each.log_ns, each.message()) for each in when_full.messages()]
        assert read == samples[: len(read)]
        assert when_full.losses == Counter()


def test_a_folder_that_may_not_be_looked_into_is_reported_so(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(folder: Path) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", str(folder))

    monkeypatch.setattr(Path, "iterdir", refuse)  # root may look into any
    with pytest.raises(RecordingError, match="Permission denied"):
        open_recording(tmp_path)
