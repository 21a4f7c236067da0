"""`ods replay --live` as a process: what `ods watch` receives of it, how it ends, what it says of bad input."""

import os
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from ods.cli import main
from ods.client import Obstacles, Replay
from tests.recording.mcap_samples import mission, write_segment
from tests.recording.record_samples import chain

ROOT = Path(__file__).parents[2]


@pytest.fixture
def record(tmp_path: Path) -> Path:
    """Return a recording of about 2 s."""
    return write_segment(tmp_path / "a.mcap", mission(14))


@pytest.fixture
def run_dir() -> Iterator[Path]:
    """Return a folder whose path is short enough for sockets."""
    with chain() as empty:
        yield empty.run_dir


def test_it_runs_until_it_is_reported_to_end(record: Path, run_dir: Path) -> None:
    command = [sys.executable, "-m", "ods", "replay", str(record), "--live", "--loop", "--run-dir", str(run_dir)]
    process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True, cwd=ROOT, env=dict(os.environ))
    planner, asker = Obstacles(run_dir, stale_s=60.0), Replay(run_dir, timeout_s=20.0)
    try:
        assert planner.next().valid
        assert asker.go(speed=10.0).speed == 10.0
        assert [planner.next().valid for _ in range(20)] == [True] * 20  # more than there are: it begins anew
        assert asker.pause().published > 14 * 18
    finally:
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=20)
        planner.close()
        asker.close()
    assert (process.returncode, said) == (130, "")


def test_it_tells_what_it_published(record: Path, run_dir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    fast = ["replay", str(record), "--live", "--speed", "100", "--run-dir", str(run_dir)]
    assert main(fast) == 0
    assert capsys.readouterr().out == f"{record}: {14 * 18} messages published\n"
    assert main([*fast, "--topics", "ping", "--from", "0.5", "--to", "1.0"]) == 0
    assert capsys.readouterr().out == f"{record}: 4 messages published\n"  # the pings of 4/7, 5/7, 6/7, 7/7 s


def test_bad_input_is_one_line(record: Path, run_dir: Path, capsys: pytest.CaptureFixture[str]) -> None:
    live = ["--live", "--run-dir", str(run_dir)]
    assert main(["replay", str(record), *live, "--from", "100"]) == 2
    assert capsys.readouterr().err == "ods replay: there is nothing to replay in the recording\n"
    assert main(["replay", str(ROOT / "README.md"), *live]) == 1
    assert capsys.readouterr().err.count("\n") == 1
    with chain("tracker") as running:
        assert main(["replay", str(record), "--live", "--run-dir", str(running.run_dir)]) == 2
    assert "another `ods tracker` already runs" in capsys.readouterr().err
    for wrong in (["--speed", "0"], ["--from", "-1"], ["--to", "soon"], ["--topics", "depth"]):
        with pytest.raises(SystemExit) as ended:
            main(["replay", str(record), *live, *wrong])
        assert ended.value.code == 2
        assert capsys.readouterr().err.count("\n") == 1
