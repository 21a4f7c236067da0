"""The supervisor with small processes of its own: restarts, hangs, give-up, clean stop."""

import os
import shutil
import signal
import subprocess
import sys
import textwrap
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ods.runtime.processes import on_board
from ods.runtime.supervisor import RestartPolicy, SuperviseSettings

DEPLOY = Path(__file__).parents[2] / "deploy"


def start(tmp_path: Path, body: str, settings: str = "") -> "subprocess.Popen[str]":
    """Start a supervisor over one child that runs `body`; the child appends its pid to `pids`."""
    child = tmp_path / "child.py"
    child.write_text(
        "import os, signal, sys, time\n"
        "from ods.runtime.service import notify\n"
        f"open({str(tmp_path / 'pids')!r}, 'a').write(f'{{os.getpid()}}\\n')\n" + textwrap.dedent(body)
    )
    script = f"""
        import logging, sys
        from pathlib import Path
        from ods.runtime import supervisor
        from ods.base.errors import OdsError
        from ods.runtime.processes import PROCESSES
        logging.basicConfig(level="INFO")
        supervisor._command = lambda *_: [sys.executable, {str(child)!r}]
        settings = supervisor.SuperviseSettings(first_delay_s=0.02, longest_delay_s=0.1, {settings})
        try:
            supervisor.supervise([PROCESSES["nav"]], Path("x"), Path({str(tmp_path)!r}), settings)
        except OdsError as error:
            sys.exit(str(error))
    """
    return subprocess.Popen([sys.executable, "-c", textwrap.dedent(script)], stderr=subprocess.PIPE, text=True)


def pids(tmp_path: Path, count: int, timeout_s: float = 20.0) -> list[int]:
    """Wait until `count` children have been started."""
    deadline = time.monotonic() + timeout_s
    while time.monotonic() < deadline:
        file = tmp_path / "pids"
        found = [int(line) for line in file.read_text().split()] if file.exists() else []
        if len(found) >= count:
            return found
        time.sleep(0.02)
    raise AssertionError(f"never saw {count} starts")


WORK = """
    notify("READY=1")
    while True:
        notify("WATCHDOG=1")
        time.sleep(0.05)
"""


def test_a_killed_child_comes_back_and_stops_cleanly(tmp_path: Path) -> None:
    supervisor = start(tmp_path, WORK)
    os.kill(pids(tmp_path, 1)[0], signal.SIGKILL)
    second = pids(tmp_path, 2)[1]
    time.sleep(0.3)
    begun = time.monotonic()
    supervisor.send_signal(signal.SIGTERM)
    assert supervisor.wait(5) == 0
    assert time.monotonic() - begun < 2.0
    assert not Path(f"/proc/{second}").exists()


def test_a_hung_child_is_killed_and_started_again(tmp_path: Path) -> None:
    supervisor = start(tmp_path, 'notify("READY=1\\nWATCHDOG=1")\ntime.sleep(1000)', "watchdog_s=0.3")
    first = pids(tmp_path, 2)[0]
    assert not Path(f"/proc/{first}").exists()
    supervisor.terminate()
    assert supervisor.stderr is not None
    assert "nav shows no sign of life: killed" in supervisor.stderr.read()


def test_a_child_that_cannot_be_kept_up_ends_the_run_with_a_reason(tmp_path: Path) -> None:
    supervisor = start(tmp_path, "sys.exit(7)", "restarts=3")
    assert supervisor.wait(20) != 0
    assert supervisor.stderr is not None
    assert "nav cannot be kept up: ended with code 7, 3 restarts within 60 s" in supervisor.stderr.read()
    assert len(pids(tmp_path, 4)) == 4


def test_exit_code_2_is_not_tried_again(tmp_path: Path) -> None:
    supervisor = start(tmp_path, "sys.exit(2)")
    assert supervisor.wait(20) != 0
    assert len(pids(tmp_path, 1)) == 1


def test_a_child_that_ignores_sigterm_is_killed_in_time(tmp_path: Path) -> None:
    supervisor = start(tmp_path, "signal.signal(signal.SIGTERM, signal.SIG_IGN)\n" + textwrap.dedent(WORK))
    child = pids(tmp_path, 1)[0]
    time.sleep(0.5)
    begun = time.monotonic()
    supervisor.terminate()
    assert supervisor.wait(5) == 0
    assert time.monotonic() - begun < 2.0
    assert not Path(f"/proc/{child}").exists()


@given(st.lists(st.floats(0.0, 100.0), max_size=50))
def test_restart_policy_never_exceeds_its_rate_nor_its_longest_delay(gaps: list[float]) -> None:
    settings = SuperviseSettings(restarts=4, window_s=60.0)
    policy = RestartPolicy(settings)
    now = 0.0
    granted: list[float] = []
    for gap in gaps:
        now += gap
        recent = [at for at in granted if now - at <= settings.window_s]
        delay = policy.delay(now)
        assert (delay is None) == (len(recent) >= settings.restarts)
        if delay is not None:
            assert settings.first_delay_s <= delay <= settings.longest_delay_s
            granted.append(now)


def test_deploy_units_name_the_processes_of_the_table() -> None:
    target = (DEPLOY / "ods.target").read_text()
    wants = next(line for line in target.splitlines() if line.startswith("Wants="))
    assert wants.removeprefix("Wants=").split() == [f"ods@{process.name}.service" for process in on_board()]
    assert "ExecStart=/opt/ods/bin/ods %i --config" in (DEPLOY / "ods@.service").read_text()


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
def test_systemd_takes_the_unit_without_a_word_and_calls_it_hardened(tmp_path: Path) -> None:
    unit = tmp_path / "ods@nav.service"
    unit.write_text((DEPLOY / "ods@.service").read_text().replace("/opt/ods/bin/ods", "/bin/true"))
    verify = ["systemd-analyze", "verify", "--recursive-errors=no", str(unit)]  # it exits with 0 on unknown keys
    assert subprocess.run(verify, capture_output=True, text=True).stderr == ""
    security = ["systemd-analyze", "security", "--offline=true", "--threshold=30", str(unit)]
    assert subprocess.run(security, capture_output=True).returncode == 0
