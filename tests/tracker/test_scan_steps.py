"""What `benchmarks.tracker --against` runs in each checkout."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from benchmarks.tracker.against import STEPS
from ods.assess.track.case import observe, save_case
from ods.assess.track.scenarios import clock, world


def test_all_scans_are_timed_in_turns(tmp_path: Path) -> None:
    scene = world(clock(2.2), np.array([[40.0, 5.0, 4.0]]), np.zeros((1, 3)), np.ones(1), 0.0)
    save_case(observe("one object", scene, np.random.default_rng(0)), tmp_path / "one.npz")
    words = [sys.executable, "-P", str(STEPS), str(tmp_path / "one.npz")]
    reported = subprocess.run(words, input="0\n0\n0\n", capture_output=True, text=True, check=True).stdout
    turns = [json.loads(line) for line in reported.splitlines()]
    assert [len(turn) for turn in turns] == [10, 5, 0]
    assert all(ms >= 0.0 for turn in turns for ms in turn)
