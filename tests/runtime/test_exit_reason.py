"""Why a process ended, for a tracker that no supervisor tells: by the real commands, as units start them."""

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
import zmq

from ods.runtime.bus import Publisher
from ods.runtime.state_files import exit_reason
from tests.locked_folder import lock

CONFIG = Path(__file__).parents[2] / "config" / "onboard.toml"


@pytest.fixture
def folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="ods-") as name:
        yield Path(name)


def test_a_process_that_cannot_start_leaves_the_reason_and_the_next_one_takes_it_away(folder: Path) -> None:
    config = folder / "onboard.toml"
    text = CONFIG.read_text().replace("[bus]", f'[bus]\nrun_dir = "{folder}"')
    config.write_text(text.replace("[pipeline]", '[pipeline]\nplugins = ["missing.py"]'))
    command = [sys.executable, "-m", "ods", "pipeline", "--config", str(config)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    words = exit_reason.read(folder, "pipeline")
    assert "missing.py" in words
    assert words in done.stderr
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = Publisher(context, folder, "pipeline")
    exit_reason.write(folder, "pipeline", "a second one that may not start")
    assert exit_reason.read(folder, "pipeline") == ""
    publisher.close()
    context.term()
    assert exit_reason.read(folder, "pipeline") == ""


def test_where_the_run_folder_may_not_be_looked_into_none_are_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lock(monkeypatch, tmp_path)
    exit_reason.write(tmp_path / "run", "tracker", "the reason, which a traceback had hidden")


def test_words_are_bounded_and_plain(folder: Path) -> None:
    exit_reason.write(folder, "nav", "line\n\x1b[31m" + 10_000 * "x")
    assert exit_reason.read(folder, "nav").startswith("line  [31mxxx")
    assert len(exit_reason.read(folder, "nav")) == exit_reason.LONGEST_WORDS
    (folder / "sonar.lock").symlink_to(folder / "nav.lock")
    assert exit_reason.read(folder, "sonar") == ""
    exit_reason.write(folder / "nowhere", "nav", "words")
    assert not (folder / "nowhere").exists()
