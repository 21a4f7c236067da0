"""The run folder among other users: what they cannot have prepared, changed, received or slipped in."""

import os
import re
import shutil
import socket
import stat
import subprocess
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
import zmq

from ods.client import Obstacles, Sonar, SonarError
from ods.messages import ObstacleList
from ods.runtime import bus, run_dir as run_dir_module, supervisor
from ods.runtime.processes import PROCESSES
from ods.runtime.run_dir import Lock, RunDirError, is_locked, prepare

CONFIG = Path(__file__).parents[2] / "config"
NO_CLIENT, GROUP = 65534, 65533
as_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root can become somebody else")


@pytest.fixture
def place() -> Iterator[Path]:
    """A folder like /tmp: all may make files in it."""
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:
        Path(folder).chmod(0o1777)
        yield Path(folder)


@pytest.fixture(params=[0o000, 0o022, 0o077], ids=oct)
def umask(request: pytest.FixtureRequest) -> Iterator[None]:
    before = os.umask(request.param)
    yield
    os.umask(before)


def by(uid: int, gid: int, act: Callable[[], object]) -> bool:
    """Do something as another user in a child process; tell whether it was let."""
    child = os.fork()
    if child == 0:
        try:
            os.setgroups([])
            os.setresgid(gid, gid, gid)
            os.setresuid(uid, uid, uid)
            act()
        except PermissionError:
            os._exit(1)
        except BaseException:
            os._exit(2)
        os._exit(0)
    code = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    assert code in (0, 1)
    return code == 0


def mode(path: Path) -> int:
    return stat.S_IMODE(path.stat().st_mode)


def connect(path: Path) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_STREAM) as client:
        client.connect(str(path))


@pytest.mark.usefixtures("umask")
def test_modes_do_not_depend_on_the_umask(place: Path) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    run_dir = place / "run"
    publisher = bus.Publisher(context, run_dir, "sonar")
    responder = bus.Responder(context, run_dir, "sonar-requests")
    child = supervisor.Child(PROCESSES["nav"], ["true"], run_dir, supervisor.SuperviseSettings())
    found = {path.name: mode(path) for path in run_dir.iterdir()}
    child.reap(0.0)
    responder.close()
    publisher.close()
    context.term()
    assert mode(run_dir) == 0o750
    assert found == {"sonar.sock": 0o660, "sonar-requests.sock": 0o660, "nav.notify": 0o600, "sonar.lock": 0o640}


@as_root
def test_a_planner_of_the_group_may_connect_and_nobody_else(place: Path) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    run_dir = place / "run"
    prepare(run_dir)
    os.chown(run_dir, 0, GROUP)
    publisher = bus.Publisher(context, run_dir, "tracker")
    os.chown(run_dir / "tracker.sock", 0, GROUP)
    assert by(NO_CLIENT, GROUP, lambda: connect(run_dir / "tracker.sock"))
    assert not by(NO_CLIENT, GROUP, (run_dir / "tracker.sock").unlink)
    assert not by(NO_CLIENT, NO_CLIENT, lambda: connect(run_dir / "tracker.sock"))
    assert not by(NO_CLIENT, NO_CLIENT, lambda: list(run_dir.iterdir()))
    publisher.close()
    context.term()


@as_root
def test_a_folder_that_another_user_made_beforehand_is_refused(place: Path) -> None:
    """The attack: his folder, in it a lock that is a symbolic link to a file of the victim."""
    victim, run_dir = place / "victim", place / "run"
    victim.write_text("precious")

    def attack() -> None:
        run_dir.mkdir(mode=0o777)
        (run_dir / "nav.lock").symlink_to(victim)

    assert by(NO_CLIENT, NO_CLIENT, attack)
    with pytest.raises(RunDirError, match=r"^bus.run_dir: \S+ belongs to user nobody, and this runs as user root"):
        Lock(run_dir, "nav")
    assert victim.read_text() == "precious"


def test_what_others_can_change_is_refused(place: Path) -> None:
    (place / "own").mkdir(mode=0o700)
    (place / "link").symlink_to(place / "own")
    (place / "file").touch()
    (place / "open").mkdir()
    (place / "open").chmod(0o1777)
    (place / "loose").mkdir()
    (place / "loose").chmod(0o777)
    refused = {
        "link": "is a symbolic link",
        "file": "is not a folder",
        "open": "every user can write in .*: chmod o-w",
        "loose/run": "another user could replace .*loose/run, because others can write to .*loose",
    }
    for name, complaint in refused.items():
        with pytest.raises(RunDirError, match=f"^bus.run_dir: .*{complaint}"):
            prepare(place / name)
    assert len({*place.rglob("*.lock")}) == 0


@as_root
@pytest.mark.parametrize(
    ("parent", "folder", "complaint"),
    [
        (0o755, 0o750, ""),
        (0o1777, 0o750, "belongs to user nobody"),
        (0o755, 0o770, "belongs to user nobody"),
        (0o755, 0o757, "every user can write in"),
        (0o777, 0o750, "belongs to user nobody"),
    ],
    ids=["as the units do", "in a folder like /tmp", "its group may write", "all may write", "all may replace it"],
)
def test_who_listens_believes_the_processes_user_only(place: Path, parent: int, folder: int, complaint: str) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    run_dir = place / "deep" / "run"
    run_dir.mkdir(parents=True)
    publisher = bus.Publisher(context, run_dir, "tracker")
    os.chown(run_dir, NO_CLIENT, NO_CLIENT)
    run_dir.parent.chmod(parent)
    run_dir.chmod(folder)
    client = Obstacles(run_dir, stale_s=0.2)
    for seq in range(2 if complaint else 8):
        publisher.publish("obstacles", ObstacleList(seq, seq, 0, 0, 0, True, [], []))
        if (got := client.next()).valid:
            break
    assert got.valid == (not complaint)
    assert complaint in "".join(got.reasons)
    with pytest.raises(SonarError, match=complaint or "no answer"):
        Sonar(run_dir, timeout_s=0.1).set_range(20.0)
    client.close()
    publisher.close()
    context.term()


def test_the_groups_right_to_write_is_taken_away(place: Path) -> None:
    (place / "run").mkdir()
    (place / "run").chmod(0o770)
    prepare(place / "run")
    assert mode(place / "run") == 0o750


@pytest.mark.parametrize("kind", ["symbolic link", "second name", "pipe"])
def test_a_lock_that_is_none_is_refused_and_nothing_is_emptied(place: Path, kind: str) -> None:
    victim, run_dir = place / "victim", place / "run"
    victim.write_text("precious")
    prepare(run_dir)
    lock = run_dir / "nav.lock"
    if kind == "symbolic link":
        lock.symlink_to(victim)
    elif kind == "second name":
        lock.hardlink_to(victim)
    else:
        os.mkfifo(lock)
    with pytest.raises(RunDirError, match=f"^bus.run_dir: .*{re.escape(str(lock))}"):
        Lock(run_dir, "nav")
    assert not is_locked(run_dir, "nav")
    assert victim.read_text() == "precious"


@pytest.mark.parametrize("module", ["msgspec", "heapq"])
@pytest.mark.parametrize("option", ["-P", "-m ods", "control"])
def test_nothing_is_imported_from_the_current_folder(tmp_path: Path, option: str, module: str) -> None:
    """By the children of `ods run`, nor by `python -m ods run` itself; the control is a program that does not care."""
    (tmp_path / f"{module}.py").write_text("open('taken', 'w').close()\nraise SystemExit(9)\n")
    command = supervisor._command(PROCESSES["nav"], Path("none.toml"), "info")
    assert command[:3] == [sys.executable, "-P", "-m"]
    if option == "-m ods":
        command = [sys.executable, "-m", "ods", "run", "--config", "none.toml"]
    elif option == "control":
        command = [sys.executable, "-c", "from ods.cli import main; main(['run', '--config', 'none.toml'])"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, check=False)
    assert (done.returncode, (tmp_path / "taken").exists()) == ((9, True) if option == "control" else (2, False))


def test_a_running_process_makes_anew_what_is_removed(place: Path) -> None:
    """As cleaners of /tmp do: late planners are received, early ones stay connected, a second process stays out."""
    run_dir = place / "run"
    text = (CONFIG / "onboard.toml").read_text().replace("[bus]", f'[bus]\nrun_dir = "{run_dir}"')
    config = place / "onboard.toml"
    config.write_text(text.replace("/dev/ttyUSB0", "/dev/none"))
    command = [sys.executable, "-m", "ods", "sonar", "--config", str(config)]
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    with (
        bus.Subscriber(context, run_dir, [], ["sonar"]) as early,
        subprocess.Popen(command, stderr=subprocess.PIPE) as ods,
    ):
        assert early.receive(30.0)[0]
        shutil.rmtree(run_dir)
        with bus.Subscriber(context, run_dir, [], ["sonar"]) as late:
            assert late.receive(10.0)[0]
        connect(run_dir / "sonar-requests.sock")
        early.receive(0.0)
        assert early.receive(10.0)[0]
        second = subprocess.run(command, capture_output=True, text=True, check=False)
        assert (second.returncode, "another `ods sonar` already runs" in second.stderr) == (2, True)
        ods.terminate()
        assert b"had been removed; created them again" in ods.communicate()[1]
    context.term()
    assert ods.returncode == 0


@pytest.mark.parametrize(
    ("uid", "there", "environment", "wanted"),
    [
        (0, False, {"XDG_RUNTIME_DIR": "/run/user/0"}, "service"),
        (1000, True, {"XDG_RUNTIME_DIR": "/run/user/1000"}, "service"),
        (1000, False, {"XDG_RUNTIME_DIR": "/run/user/1000"}, "/run/user/1000/ods"),
        (1000, False, {"HOME": "/home/me"}, "/home/me/.local/state/ods/run"),
    ],
)
def test_the_default_is_the_services_folder_or_the_users_own(
    place: Path, monkeypatch: pytest.MonkeyPatch, uid: int, there: bool, environment: dict[str, str], wanted: str
) -> None:
    service = place / "service"
    if there:
        service.mkdir()
    monkeypatch.setattr(run_dir_module, "SERVICE_DIR", service)
    monkeypatch.setattr(os, "geteuid", lambda: uid)
    monkeypatch.delenv("XDG_RUNTIME_DIR", raising=False)
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    assert bus.BusSettings().run_dir == place / wanted


def test_who_lost_its_lock_to_another_process_ends(place: Path) -> None:
    lock = Lock(place / "run", "nav")
    assert not lock.restore()
    (place / "run" / "nav.lock").unlink()
    other = Lock(place / "run", "nav")
    with pytest.raises(RunDirError, match="another `ods nav` already runs"):
        lock.restore()
    other.close()
    assert lock.restore()
    assert is_locked(place / "run", "nav")
    lock.close()
