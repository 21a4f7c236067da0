"""The supervisor with small processes of its own: restarts without end, hangs, clean stop."""

import errno
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import textwrap
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import zmq

from ods.base.clock import NS
from ods.base.computer.overload import STARVED, ProcessorTime
from ods.runtime import bus, service, supervisor as supervisor_module
from ods.runtime.processes import PROCESSES, SUPERVISOR
from ods.runtime.supervisor import HELD, Child, SuperviseSettings

pytestmark = pytest.mark.slow

DEPLOY = Path(__file__).parents[2] / "deploy"
STARTED: list["subprocess.Popen[str]"] = []


@pytest.fixture(autouse=True)
def no_supervisor_outlives_its_test() -> Iterator[None]:
    """One whose test failed would start children for ever."""
    yield
    while STARTED:
        supervisor = STARTED.pop()
        supervisor.terminate()
        supervisor.communicate(timeout=10)


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
    command = [sys.executable, "-c", textwrap.dedent(script)]
    STARTED.append(subprocess.Popen(command, stderr=subprocess.PIPE, text=True))
    return STARTED[-1]


def pids(tmp_path: Path, count: int, timeout_s: float = 60.0) -> list[int]:
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
    assert "nav sent no watchdog message in time: killed" in supervisor.stderr.read()


def test_children_that_were_stopped_with_the_supervisor_are_not_killed(tmp_path: Path) -> None:
    """As by Ctrl-Z, a paused container or a stopped virtual machine."""
    supervisor = start(tmp_path, WORK, "watchdog_s=2.0")
    (child,) = pids(tmp_path, 1)
    time.sleep(0.5)
    for pid in (child, supervisor.pid):
        os.kill(pid, signal.SIGSTOP)
    time.sleep(2.5)
    os.kill(supervisor.pid, signal.SIGCONT)
    time.sleep(0.3)
    os.kill(child, signal.SIGCONT)
    time.sleep(0.5)
    assert pids(tmp_path, 1) == [child]
    assert Path(f"/proc/{child}").exists()


def test_a_child_that_is_at_work_while_it_starts_is_not_killed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """A slow computer was restarted into being slower."""
    child = Child(PROCESSES["nav"], ["sleep", "1000"], tmp_path, SuperviseSettings(start_s=10.0))
    spent = [ProcessorTime(0, 0)]
    monkeypatch.setattr(supervisor_module, "processor_time", lambda _: spent[0])
    child.step(0.0)
    first = child.pid
    spent[0] = ProcessorTime(ran_ns=8 * NS, waited_ns=0)
    child.step(11.0)
    assert (child.pid, child.busy) == (first, "is starting, for 11 s")
    spent[0] = ProcessorTime(ran_ns=9 * NS, waited_ns=8 * NS)
    child.step(22.0)
    assert (child.pid, child.busy) == (first, STARVED)
    child.step(33.0)  # neither ran nor waited for a processor since
    assert child.pid == 0
    assert caplog.text.count("nav has sent no watchdog message yet") == 1
    assert "nav sent no watchdog message in time: killed" in caplog.text
    child.reap(0.0)


def test_a_starved_child_is_waited_for_longer_than_one_that_hangs_but_not_for_ever(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    child = Child(PROCESSES["nav"], ["sleep", "1000"], tmp_path, SuperviseSettings(watchdog_s=3.0))
    waited_s = 0.0
    monkeypatch.setattr(supervisor_module, "processor_time", lambda _: ProcessorTime(0, round(waited_s * NS)))
    monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "nav.notify"))
    child.step(0.0)
    service.notify("WATCHDOG=1")
    child.step(1.0)
    first = child.pid
    for waited_s in range(4, 28, 3):
        child.step(1.0 + waited_s)
        assert (child.pid, child.busy) == (first, STARVED)
    waited_s = 31
    child.step(32.0)
    assert child.pid == 0
    child.reap(0.0)


def test_a_child_lives_on_when_the_run_folder_is_emptied(tmp_path: Path) -> None:
    supervisor = start(tmp_path, WORK, "watchdog_s=0.5")
    first = pids(tmp_path, 1)
    time.sleep(0.5)
    for pattern in ("*.notify", "*.lock", "*.sock"):
        for file in tmp_path.glob(pattern):
            file.unlink()
    time.sleep(1.5)
    assert {file.name for file in tmp_path.iterdir()} >= {"nav.notify", "run.lock", "run.sock"}
    supervisor.terminate()
    assert supervisor.wait(5) == 0
    assert pids(tmp_path, 1) == first


@pytest.mark.parametrize("code", [2, 7])
def test_a_child_that_cannot_start_is_tried_again_without_end_and_its_reason_is_reported(
    tmp_path: Path, code: int
) -> None:
    supervisor = start(tmp_path, f'notify("STOPPING=1\\nSTATUS=the key x is wrong")\nsys.exit({code})')
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    with bus.Subscriber(context, tmp_path, [], [SUPERVISOR]) as subscriber:
        pids(tmp_path, 12)
        reported = [message for _, message in subscriber.receive(5.0)[0]]
    context.term()
    assert supervisor.poll() is None
    supervisor.terminate()
    assert supervisor.wait(5) == 0
    assert {(each.process, each.ready) for each in reported} == {("nav", False)}
    assert reported[-1].problems == [f"ended with code {code}: the key x is wrong"]


def test_delays_grow_to_the_longest_and_begin_anew_after_work(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    settings = SuperviseSettings(first_delay_s=0.5, longest_delay_s=3.0, settled_s=60.0)
    child = Child(PROCESSES["nav"], ["false"], tmp_path, settings)
    now_s = 0.0
    for up_s in (0.0, 59.0, 0.0, 0.0, 60.0, 0.0):
        child.step(now_s)
        now_s += up_s
        ended = len(caplog.messages)
        while len(caplog.messages) == ended:
            time.sleep(0.01)
            child.step(now_s)
        now_s += 3.0
    child.reap(0.0)
    delays = [float(match[1]) for text in caplog.messages if (match := re.search(r"restarting it in (\S+) s", text))]
    assert delays == [0.5, 1.0, 2.0, 3.0, 0.5, 1.0]


def test_a_child_that_ignores_sigterm_is_killed_in_time(tmp_path: Path) -> None:
    supervisor = start(
        tmp_path, "signal.signal(signal.SIGTERM, signal.SIG_IGN)\n" + textwrap.dedent(WORK), "stop_s=1.0"
    )
    child = pids(tmp_path, 1)[0]
    time.sleep(0.5)
    begun = time.monotonic()
    supervisor.terminate()
    assert supervisor.wait(20) == 0
    assert time.monotonic() - begun < 10.0
    assert not Path(f"/proc/{child}").exists()


@pytest.fixture
def unkillable(monkeypatch: pytest.MonkeyPatch) -> None:
    """Processes in which the kernel waits for a disk: SIGKILL has to wait. No test waits as long."""
    monkeypatch.setattr(subprocess.Popen, "kill", lambda _: None)
    waited = subprocess.Popen.wait

    def wait(self: "subprocess.Popen[bytes]", timeout: float | None = None) -> int:
        return waited(self, 20.0 if timeout is None else timeout)

    monkeypatch.setattr(subprocess.Popen, "wait", wait)


@pytest.mark.usefixtures("unkillable")
def test_a_child_that_cannot_be_killed_holds_up_nobody(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    """`ods run` waited for its end for ever, and all the others for `ods run`."""
    child = Child(PROCESSES["tracker"], ["sleep", "1000"], tmp_path, SuperviseSettings(start_s=10.0))
    child.step(0.0)
    held = child.pid
    for now_s in (11.0, 12.0, 13.0):
        child.step(now_s)
        assert (child.pid, child.down) == (held, HELD)
    assert [record.message for record in caplog.records if record.levelname == "ERROR"] == [
        "tracker sent no watchdog message in time: killed",
        f"tracker {HELD}: restarting it once it has ended",
    ]
    os.kill(held, signal.SIGKILL)
    while child.pid == held:
        child.step(14.0)
    assert child.down == "killed by signal 9: it sent no watchdog message in time"
    child.step(15.0)
    other = child.pid
    assert other not in (0, held)
    child.reap(0.0)
    assert f"pid {other} keeps running" in caplog.text
    os.kill(other, signal.SIGKILL)
    os.waitpid(other, 0)


def test_a_child_that_the_computer_cannot_start_is_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """The supervisor ended, and all the others with it."""
    child = Child(PROCESSES["nav"], ["sleep", "1000"], tmp_path, SuperviseSettings(first_delay_s=0.5))
    with monkeypatch.context() as patch:
        patch.setattr(subprocess, "Popen", no_memory)
        child.step(0.0)
        child.step(0.4)
        assert (child.pid, child.down) == (0, "cannot be started: cannot allocate memory")
        child.step(0.6)
    assert [text for text in caplog.messages if "cannot" in text] == [
        f"nav cannot be started: cannot allocate memory: trying again in {delay_s} s" for delay_s in (0.5, 1.0)
    ]
    child.step(1.7)
    assert child.pid
    child.reap(0.0)


def no_memory(*_: object, **__: object) -> None:
    raise OSError(errno.ENOMEM, os.strerror(errno.ENOMEM))


def test_a_supervisor_that_does_not_listen_holds_up_nobody(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as deaf:
        deaf.bind(str(tmp_path / "notify"))
        monkeypatch.setenv("NOTIFY_SOCKET", str(tmp_path / "notify"))

        reported: list[bool] = []

        def tell() -> None:
            reported.extend(service.notify("WATCHDOG=1") for _ in range(1000))

        telling = threading.Thread(target=tell, daemon=True)
        telling.start()
        telling.join(20.0)
        assert not telling.is_alive()
        assert (reported[0], reported[-1]) == (True, False)
        assert deaf.recv(100) == b"WATCHDOG=1"


def test_deploy_units_name_the_processes_of_the_table() -> None:
    target = (DEPLOY / "ods.target").read_text()
    wants = next(line for line in target.splitlines() if line.startswith("Wants="))
    assert wants.removeprefix("Wants=").split() == [
        f"ods@{process.name}.service" for process in PROCESSES.values() if process.on_board
    ]
    assert "ExecCondition=/opt/ods/bin/ods record --is-on --config" in (DEPLOY / "record.conf").read_text()
    assert "ExecStart=/opt/ods/bin/ods %i --config" in (DEPLOY / "ods@.service").read_text()


@pytest.mark.skipif(shutil.which("systemd-analyze") is None, reason="systemd is not installed")
def test_systemd_takes_the_unit_without_a_word_and_calls_it_hardened(tmp_path: Path) -> None:
    unit = tmp_path / "ods@nav.service"
    unit.write_text((DEPLOY / "ods@.service").read_text().replace("/opt/ods/bin/ods", "/bin/true"))
    assert "\nProcSubset=pid" not in unit.read_text()  # the tracker could not start: no boot_id
    verify = ["systemd-analyze", "verify", "--recursive-errors=no", str(unit)]  # it exits with 0 on unknown keys
    assert subprocess.run(verify, capture_output=True, text=True).stderr == ""
    security = ["systemd-analyze", "security", "--offline=true", "--threshold=30", str(unit)]
    assert subprocess.run(security, capture_output=True).returncode == 0
