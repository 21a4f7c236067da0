"""`ods bench` where a process cannot start."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from ods.bench import runner
from ods.cli import main

CONFIG = Path(__file__).parents[2] / "config"


@pytest.fixture
def folder() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="ods-") as name:  # a socket path must be short
        yield Path(name)


def test_a_process_that_cannot_start_ends_it_at_once_with_its_reason(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    shutil.copytree(CONFIG, folder / "config")
    onboard, bench = folder / "config" / "onboard.toml", folder / "config" / "bench.toml"
    onboard.write_text(onboard.read_text().replace("[pipeline]", '[pipeline]\nplugins = ["none.py"]'))
    bench.write_text(bench.read_text().replace("/tmp/ods-bench", f"{folder}/run"))
    begun = time.monotonic()
    assert main(["bench", "--config", str(bench), "--out", str(folder / "out")]) == 2
    assert time.monotonic() - begun < runner.START_S / 2
    said = capsys.readouterr().err
    assert said.startswith("ods bench: pipeline ended with code 2: pipeline.plugins[0]")
    assert "none.py): FileNotFoundError" in said
    assert said.count("\n") == 1


def test_a_folder_of_results_that_cannot_be_made_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bench", "--config", str(CONFIG / "bench.toml"), "--out", "/dev/null/out"]) == 2
    assert capsys.readouterr().err == "ods bench: /dev/null/out: not a directory: --out names another folder\n"


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGKILL])
def test_no_process_outlives_a_bench_that_is_killed(folder: Path, number: signal.Signals) -> None:
    config, log = folder / "onboard.toml", folder / "run.log"
    config.write_text(
        (CONFIG / "onboard.toml").read_text().replace("[bus]", f'[bus]\nrun_dir = "{folder}/run"')
        .replace('_eds = "', f'_eds = "{CONFIG}/')
    )  # fmt: skip
    program = (
        "import time; from pathlib import Path; from ods.bench.program import Program\n"
        f"with Program('run', Path({str(config)!r}), Path({str(log)!r})): time.sleep(100)"
    )
    bench = subprocess.Popen([sys.executable, "-c", program], env=os.environ | {"NUMBA_DISABLE_JIT": "1"})
    while not log.is_file() or log.read_text().count(" started (pid ") < 4:
        assert bench.poll() is None
        time.sleep(0.05)
    started = psutil.Process(bench.pid).children(recursive=True)
    assert len(started) >= 5
    bench.send_signal(number)
    bench.wait()
    _ended, left = psutil.wait_procs(started, timeout=20.0)
    for process in left:
        process.kill()
    assert left == []
