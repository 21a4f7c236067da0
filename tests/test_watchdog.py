"""A run of pytest that hangs ends, and says where."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

PROJECT = Path(__file__).parents[1]
CONFTEST = """
from tests import watchdog
from tests.watchdog import *
watchdog.GRACE_S = 1.0
"""
FAILED_TEST = """
import pytest, time

@pytest.fixture
def thing():
    yield
    hanging_teardown()

def hanging_teardown():
    time.sleep(1000.0)

def test_that_fails(thing):
    assert False
"""
SWALLOWED_ALARM = """
import asyncio, time

def hanging_callback():
    time.sleep(0.01)
    asyncio.get_running_loop().call_soon(hanging_callback)

async def test_that_waits():
    hanging_callback()
    await asyncio.Event().wait()
"""
THREAD_LEFT = """
import threading

def hanging_thread():
    threading.Event().wait()

def test_that_passes():
    threading.Thread(target=hanging_thread).start()
"""


@pytest.mark.timeout(120)
@pytest.mark.parametrize(
    ("test", "named"),
    [(FAILED_TEST, "hanging_teardown"), (SWALLOWED_ALARM, "run_until_complete"), (THREAD_LEFT, "hanging_thread")],
)
def test_a_run_that_hangs_fails_with_a_stack(test: str, named: str, tmp_path: Path) -> None:
    """What pytest-timeout misses: teardown after a failure, an alarm within a callback, the end of the interpreter."""
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "test_it.py").write_text(test)
    run = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-o", "asyncio_mode=auto", "--timeout=2", "."],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(PROJECT)}, capture_output=True, text=True, timeout=100,
    )  # fmt: skip
    assert run.returncode == 1
    assert "Timeout (0:00:0" in run.stderr
    assert named in run.stderr


def test_a_worker_of_xdist_may_wait_for_the_others(tmp_path: Path) -> None:
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "test_it.py").write_text("def test_short(): pass")
    (tmp_path / "test_other.py").write_text("import time\ndef test_long(): time.sleep(5.0)")
    words = ["-q", "-p", "no:cacheprovider", "-n", "2", "--dist", "loadfile", "--timeout=20", "."]
    run = subprocess.run(
        [sys.executable, "-m", "pytest", *words],
        cwd=tmp_path, env={**os.environ, "PYTHONPATH": str(PROJECT)}, capture_output=True, text=True, timeout=100,
    )  # fmt: skip
    assert (run.returncode, "Timeout (" in run.stderr) == (0, False), run.stdout + run.stderr
