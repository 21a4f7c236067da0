"""A process that compiles its kernels is deaf for a minute: signals end it all the same, and whom it started."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

import psutil
import pytest

from ods.commands.compile import LEFT_S, _clear

COMPILES = {
    "compile": "from ods.compiled import machine_code; machine_code.load = lambda _: None",
    "tracker": "from ods.compiled import kernel; kernel.do_without_numba = lambda: None",
}
"""What lets a command compile though there is machine code."""
WITHIN_S = 1.0


@pytest.fixture
def started(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[psutil.Popen]:
    """Start a command, and wait until it keeps what it has compiled."""
    name = request.param
    config = tmp_path / "onboard.toml"
    text = (Path(__file__).parents[2] / "config" / "onboard-nmea.toml").read_text()
    config.write_text(text.replace("[bus]", f'[bus]\nrun_dir = "{tmp_path}/run"').replace("~/", f"{tmp_path}/"))
    code = f"{COMPILES[name]}; from ods.cli import main; raise SystemExit(main({[name, '--config', str(config)]}))"
    environment = os.environ | {"ODS_CACHE_DIR": str(tmp_path / "cache")}
    process = psutil.Popen([sys.executable, "-c", code], env=environment, stderr=subprocess.PIPE, text=True)
    deadline_s = time.monotonic() + 60.0
    while not any(tmp_path.glob("cache/**/*.nbi")):
        assert process.poll() is None
        assert time.monotonic() < deadline_s
        time.sleep(0.05)
    yield process
    with suppress(psutil.Error):
        process.kill()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
@pytest.mark.parametrize("started", COMPILES, indirect=True)
def test_who_compiles_heeds_a_signal(started: psutil.Popen, number: signal.Signals) -> None:
    all_of_it = [started, *started.children(recursive=True)]
    started.send_signal(number)
    deadline_s = time.monotonic() + WITHIN_S
    while any(map(_works, all_of_it)):
        assert time.monotonic() < deadline_s
        time.sleep(0.01)
    assert started.wait() == -number
    assert "Traceback" not in started.communicate()[1]


def _works(process: psutil.Process) -> bool:
    try:
        return bool(process.status() != psutil.STATUS_ZOMBIE)
    except psutil.NoSuchProcess:
        return False


def test_what_it_had_begun_to_write_is_cleared_next_time(tmp_path: Path) -> None:
    names = ["machine-code", "machine-code.77", "detect/a.nbi", "detect/a.nbi.tmp.0123", "detect/b.nbc.tmp.4567"]
    for name in names:
        file = tmp_path / name
        file.parent.mkdir(exist_ok=True)
        file.touch()
        if name != names[-1]:
            os.utime(file, (time.time() - 2 * LEFT_S,) * 2)  # noqa: TID251
    _clear(tmp_path)
    left = {str(file.relative_to(tmp_path)) for file in tmp_path.rglob("*") if file.is_file()}
    assert left == {"machine-code", "detect/a.nbi", "detect/b.nbc.tmp.4567"}
