"""Why a process ended, for a tracker that no supervisor tells: by the real commands, as units start them."""

import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
import zmq

from ods.runtime.bus import Publisher
from ods.runtime.state_files import last_words
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
    words = last_words.left(folder, "pipeline")
    assert "missing.py" in words
    assert words in done.stderr
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = Publisher(context, folder, "pipeline")
    last_words.leave(folder, "pipeline", "a second one that may not start")
    assert last_words.left(folder, "pipeline") == ""
    publisher.close()
    context.term()
    assert last_words.left(folder, "pipeline") == ""


def test_where_the_run_folder_may_not_be_looked_into_none_are_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    lock(monkeypatch, tmp_path)
    last_words.leave(tmp_path / "run", "tracker", "the reason, which a traceback had hidden")


def test_words_are_bounded_and_plain(folder: Path) -> None:
    last_words.leave(folder, "nav", "line\n\x1b[31m" + 10_000 * "x")
    assert last_words.left(folder, "nav").startswith("line  [31mxxx")
    assert len(last_words.left(folder, "nav")) == last_words.LONGEST_WORDS
    (folder / "sonar.lock").symlink_to(folder / "nav.lock")
    assert last_words.left(folder, "sonar") == ""
    last_words.leave(folder / "nowhere", "nav", "words")
    assert not (folder / "nowhere").exists()
