"""Every reader of files, on damaged copies of a good one, with little memory: it reads, or says why in one line."""

import subprocess
import sys
from pathlib import Path

import pytest

from tests.hostile_reader import READERS


@pytest.mark.slow
@pytest.mark.parametrize("name", READERS)
def test_a_damaged_file_is_read_or_refused_in_one_line(name: str) -> None:
    done = subprocess.run(
        [sys.executable, "-m", "tests.hostile_reader", name], cwd=Path(__file__).parents[1], capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr[-4000:]
