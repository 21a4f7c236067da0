"""`ods info` against counts made by hand."""

import re
from pathlib import Path

import pytest

from ods.base.clock import NS
from ods.cli import main
from ods.messages import Health
from tests.recording.mcap_samples import Sample, mission, write_segment


def _health(process: str, pid: int, seq: int, at_ns: int, *problems: str) -> Sample:
    return "health", at_ns, Health(process, pid, seq, at_ns, 0, True, list(problems), {}, {}, {}, {}, 1.0, 50.0)


def test_the_table_tells_counts_rates_gaps_processes_and_faults(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    samples = mission(15, 4)
    begun = samples[0][1]
    samples = [each for number, each in enumerate(samples) if number not in (8, 9, 25)]  # two poses, a ping... by place
    missed_poses = sum(1 for number in (8, 9, 25) if mission(15, 4)[number][0] == "pose")
    samples += [
        _health("nav", 11, 0, begun + NS, "the INS is silent for 1.5 s"),
        _health("nav", 11, 1, begun + 2 * NS, "the INS is silent for 12.75 s"),
        _health("nav", 12, 0, begun + 3 * NS),
    ]
    facts = {"version": "9.9", "cpu": "A CPU", "config_sha256": "ab" * 32, "utc_synchronized": "false"}
    write_segment(tmp_path / "00000.mcap", samples[:50], metadata=facts, attachments={"config.toml": b"x" * 1500})
    write_segment(tmp_path / "00001.mcap", samples[50:], finish=False)
    assert main(["info", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    print(said)
    assert "2 files" in said
    assert "3.0 s\n" in said
    assert "ods 9.9; " in said
    assert "config.toml (1.5 kB)" in said
    assert "was not synchronized" in said
    rows = dict(re.findall(r"^(\w+) +(\d+ +[\d.]+ +\d+) ", said, re.MULTILINE))
    count, rate, missed = rows["pose"].split()
    assert (int(count), int(missed)) == (60 - missed_poses, missed_poses)
    assert float(rate) == pytest.approx((int(count) - 1) / _span_s(samples, "pose"), abs=0.01)
    assert "0.0 s  nav" not in said
    assert re.search(r" 1\.0 s  nav \(pid 11\)\n +3\.0 s  nav \(pid 12\)\n", said)
    assert "1.0 s to 2.0 s  nav: the INS is silent for # s (2 reports)" in said
    assert "truncated: 00001.mcap" in said


def _span_s(samples: list[Sample], topic: str) -> float:
    times = [at_ns for name, at_ns, _ in samples if name == topic]
    return (times[-1] - times[0]) / NS


def test_a_single_file_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = write_segment(tmp_path / "a.mcap", mission(2))
    assert main(["info", str(file)]) == 0
    assert capsys.readouterr().out.startswith(f"{file}: 1 file, ")


def test_what_is_no_recording_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "a.mcap").write_bytes(b"rubbish")
    assert main(["info", str(tmp_path / "a.mcap")]) == 1
    assert capsys.readouterr().err == f"ods info: {tmp_path / 'a.mcap'}: not an MCAP file\n"
