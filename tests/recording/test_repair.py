"""`ods record --finish` on files that are damaged between their ends."""

from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.records import Header, Metadata

from ods.recording.errors import RecordingError
from ods.recording.mcap.framing import MAGIC, encoded
from ods.recording.mcap.reader import open_recording
from ods.recording.repair import repair
from tests.recording.mcap_samples import mission, write_segment


def test_a_damaged_chunk_is_left_out_so_that_all_readers_read_on_and_the_file_is_kept(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = write_segment(tmp_path / "a.mcap", mission(6))
    repair(path)
    assert "is complete" in capsys.readouterr().out
    damaged = bytearray(path.read_bytes())
    damaged[damaged.index(b"zstd") + 60] ^= 255  # in the first chunk's records
    path.write_bytes(damaged)
    repair(path)
    assert f"bad_chunks 1; original kept as {path}.damaged" in capsys.readouterr().out
    assert Path(f"{path}.damaged").read_bytes() == damaged
    with path.open("rb") as file:
        messages = list(make_reader(file, validate_crcs=True).iter_messages())
    assert len(messages) == len(list(open_recording(path).messages())) > 50
    repair(path)
    assert "is complete" in capsys.readouterr().out


def test_a_file_that_does_not_tell_its_time_is_one_line(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    path.write_bytes(MAGIC + encoded(Header("ods", "x"), Metadata("ods", {"version": "0.4.0"})))
    with pytest.raises(RecordingError, match="contains no time stamps: nothing can be repaired"):
        repair(path)
    assert list(tmp_path.iterdir()) == [path]


@pytest.mark.parametrize("where", ["summary", "attachment"])
def test_damage_outside_of_chunks_is_found_and_mended(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], where: str
) -> None:
    path = write_segment(tmp_path / "a.mcap", mission(6), attachments={"config.toml": b"precious" * 9})
    damaged = bytearray(path.read_bytes())
    at = damaged.rindex(b"jsonschema") if where == "summary" else damaged.index(b"precious")
    damaged[at] ^= 1
    path.write_bytes(damaged)
    repair(path)
    assert f"complete, {len(mission(6))} messages" in capsys.readouterr().out
    repair(path)
    assert "is complete" in capsys.readouterr().out
    with path.open("rb") as file:
        assert len(list(make_reader(file, validate_crcs=True).iter_messages())) == len(mission(6))
