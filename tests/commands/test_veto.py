"""`ods veto` against a socket that answers as the tracker does: what is asked and printed; errors in one line."""

import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from ods.cli import main
from ods.messages import VetoAnswer, VetoRequest
from ods.runtime.keys.key_folder import OPERATORS, KeyFolder
from ods.tracker.veto.operators import Operators
from tests.tracker.test_veto import obstacle, vetoed


class Board:
    """Its run folder, keys and configuration."""

    def __init__(self, folder: Path) -> None:
        self.asked: list[VetoRequest] = []
        keys = KeyFolder(folder / "keys", OPERATORS)
        self._key = keys.make("anna")
        self._config = folder / "onboard.toml"
        text = Path("config/onboard.toml").read_text()
        self._config.write_text(text.replace("[bus]", f'[bus]\nrun_dir = "{folder}"\nkeys = "{keys.path}"'))
        self._operators = Operators(keys.path, folder)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._serve)
        self._thread.start()

    def _serve(self) -> None:
        held = vetoed(obstacle(7, 20.0), "anna")
        while not self._ended.wait(0.002):
            for asked in self._operators.asked():
                self.asked.append(asked.request)
                self._operators.answer(asked, VetoAnswer(ok=True, reason="", vetoes=held))

    def run(self, *words: str) -> int:
        return main(["veto", *words, "--key", str(self._key), "--config", str(self._config)])

    def close(self) -> None:
        self._ended.set()
        self._thread.join()
        self._operators.close()


@pytest.fixture
def board() -> Iterator[Board]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        made = Board(Path(folder))
        try:
            yield made
        finally:
            made.close()


def test_what_is_asked_and_what_holds(board: Board, capsys: pytest.CaptureFixture[str]) -> None:
    assert board.run("region", "--polygon", "0", "-5", "0", "5", "9", "0", "--for", "90s", "--reason", "the pier") == 0
    (asked,) = board.asked
    assert asked.for_s == 90.0
    assert asked.region is not None
    assert asked.region.corners_ne == [(0.0, -5.0), (0.0, 5.0), (9.0, 0.0)]
    out = capsys.readouterr().out
    assert (
        out
        == "veto 0: obstacle 7 within 3.0 m around 20.0 0.0 m north east until 00:01:00 UTC, by anna: a buoy of ours\n"
    )


@pytest.mark.parametrize(
    "words",
    [
        ("ignore", "7", "--for", "5h", "--reason", "too long"),
        ("ignore", "7", "--reason", "no end"),
        ("region", "--circle", "0", "0", "1000", "--for", "1m", "--reason", "all"),
        ("region", "--polygon", "0", "0", "1", "--for", "1m", "--reason", "an odd number"),
        ("restore", "--reason", "nothing named"),
    ],
)
def test_what_makes_no_sense_is_one_line(
    words: tuple[str, ...], board: Board, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = board.run(*words)
    except SystemExit as left:
        code = int(str(left.code))
    assert code == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert board.asked == []
