"""in_vcan keeps its promises about the command it runs, whichever way it found to run it."""

import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import psutil
import pytest

from in_vcan import keeper, modules, uml
from in_vcan.job import NO_WAY, OUT_OF_TIME

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
IN_VCAN = [sys.executable, "-m", "in_vcan"]


def in_vcan(*words: str, **environment: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(
        [*IN_VCAN, *words], capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(ROOT)} | environment
    )


@pytest.fixture(scope="module")
def way() -> None:
    """Skip where no vcan can be had; tests/vcan says why and fails where one must be."""
    if in_vcan("true").returncode == NO_WAY:
        pytest.skip("no vcan to be had here")


REPORT = """
import json, os, socket, sys
links = [name for _, name in socket.if_nameindex()]
print(json.dumps([os.getcwd(), os.environ["ODS_TEST"], sys.argv[1], links]))
print("only this", file=sys.stderr)
sys.exit(7)
"""


@pytest.mark.usefixtures("way")
def test_the_command_has_folder_environment_words_and_streams_of_its_own(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = tmp_path / 'it\'s a "folder"'
    folder.mkdir()
    monkeypatch.chdir(folder)
    done = in_vcan(sys.executable, "-c", REPORT, "a  b\n$c", ODS_TEST="x y\n'")
    cwd, variable, word, links = json.loads(done.stdout)
    assert (cwd, variable, word) == (str(folder), "x y\n'", "a  b\n$c")
    assert {"vcan0", "vcan1"} <= set(links)
    assert done.stderr.splitlines()[-1] == "only this"
    assert done.returncode == 7


@pytest.mark.usefixtures("way")
def test_out_of_time_is_124() -> None:
    done = in_vcan("--timeout", "3", "sleep", "600")
    assert done.returncode == OUT_OF_TIME
    assert "out of time after 3 s" in done.stderr


@pytest.mark.usefixtures("way")
@pytest.mark.parametrize(("number", "status"), [(signal.SIGINT, 130), (signal.SIGKILL, -9)], ids=["ctrl-c", "kill"])
def test_nothing_outlives_the_runner(number: int, status: int) -> None:
    runner = subprocess.Popen(
        [*IN_VCAN, "sh", "-c", "setsid sleep 600 & echo up; exec sleep 600"],
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": str(ROOT)},
    )
    with runner:
        assert runner.stdout is not None
        assert runner.stdout.readline() == b"up\n"
        begun = psutil.Process(runner.pid).children(recursive=True)
        assert len(begun) >= 2  # of QEMU's guest the host sees no process
        runner.send_signal(number)
    assert runner.returncode == status
    assert not psutil.wait_procs(begun, timeout=10.0)[1]


def test_a_way_that_is_not_there_is_one_line_and_125() -> None:
    done = in_vcan("true", ODS_VCAN="namespace", PATH="/nonexistent")
    assert done.returncode == NO_WAY
    assert done.stderr == "in_vcan: no vcan to be had; namespace: unshare: No such file or directory\n"


def test_user_mode_linux_is_refused_on_a_cpu_with_amx() -> None:
    assert uml.has_amx("flags : fpu amx_bf16 amx_tile amx_int8\n")
    assert not uml.has_amx("flags : fpu avx512f\n")


def test_modules_come_after_those_they_need(tmp_path: Path) -> None:
    for name, needs in [("vcan", "can-dev"), ("can-dev", ""), ("can_raw", "can"), ("can", "")]:
        (tmp_path / f"{name}.ko").write_bytes(b"ELF\0license=GPL\0depends=" + needs.encode() + b"\0name=x\0")
    names = [name for name, _ in modules.in_order(tmp_path, ("vcan", "can-raw", "built-in"))]
    assert names == ["can_dev", "vcan", "can", "can_raw"]


def test_the_keeper_clears_up_after_a_command_that_failed_to_start(tmp_path: Path) -> None:
    left = tmp_path / "left"
    left.touch()
    assert keeper.keep([str(tmp_path / "nothing")], None, [["rm", str(left)]]) == 127
    assert not left.exists()


def test_time_out_of_the_keeper_is_prompt() -> None:
    begun_s = time.monotonic()
    assert keeper.keep(["sleep", "600"], 0.2, []) == OUT_OF_TIME
    assert time.monotonic() - begun_s < 60.0
