"""`ods compile` where plug-ins are named; the compiling itself is tested in tests/install."""

import subprocess
import sys
from pathlib import Path

import msgspec
import pytest

from ods.base.settings_file import load
from ods.commands.compile import _job, not_compiled
from ods.config import OnboardConfig


def test_another_plug_in_or_another_text_of_it_is_another_job(tmp_path: Path) -> None:
    plain = load(Path("config/onboard.toml"), OnboardConfig)
    file = tmp_path / "mine.py"
    plugged = msgspec.structs.replace(plain, tracker=msgspec.structs.replace(plain.tracker, plugins=(file,)))
    file.write_text("first")
    jobs = [_job(plain), _job(plugged), _job(plugged)]
    file.write_text("second")
    jobs.append(_job(plugged))
    assert jobs[1] == jobs[2]
    assert len(set(jobs)) == 3


def test_what_compiles_at_once_has_no_kernel_in_common() -> None:
    """Two processes would write one file of numba's cache: neither part may come to know the other's kernels."""
    pipeline = _kernels("ods.pipeline.warm_up")
    others = _kernels("ods.tracker.warm_up", "ods.sim_sonar.warm_up")
    assert len(pipeline) > 10
    assert len(others) > 10
    assert not pipeline & others


def _kernels(*modules: str) -> set[str]:
    code = f"import {', '.join(modules)}; from ods.compiled.kernel import DISPATCHERS; print(*DISPATCHERS)"
    told = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True)
    return set(told.stdout.split())


@pytest.mark.parametrize(
    ("names", "told"),
    [
        ([], "numba was imported"),
        (["a.b"], "a.b"),
        (["k"] * 5, "k, k, k, k, k"),
        (["k"] * 400, "k, k, k, k, k and 395 more"),
    ],
)
def test_what_is_not_compiled_is_a_line_that_can_be_read(names: list[str], told: str) -> None:
    assert not_compiled(names) == f"not compiled: {told}"
