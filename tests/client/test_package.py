"""The wheel ods-client: small, typed, and of use where there is nothing but pyzmq and msgspec."""

import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from tests.client.compiled import ROOT
from tests.install.clean_venv import bare, install

MOST_BYTES = 200_000
PROGRAM = """
import sys
from ods.client import NoListError, Obstacles, at, near_misses
lists = Obstacles(sys.argv[1], stale_s=0.1)
print(lists.next().reasons[0][:26])
print(sorted({name.partition(".")[0] for name in sys.modules} & {"numpy", "psutil", "can", "mcap"}))
"""


@pytest.fixture(scope="module")
def wheel(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Build it of a copy, so that nothing is left in the source tree."""
    folder = tmp_path_factory.mktemp("client")
    listed = subprocess.run(["git", "ls-files", "-z", "ods", "client"], cwd=ROOT, capture_output=True, check=True)
    for name in filter(None, listed.stdout.decode().split("\0")):
        if name.endswith((".py", ".toml", ".md", ".typed")) and (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes((ROOT / name).read_bytes())
    pip = [sys.executable, "-m", "pip", "--quiet", "--disable-pip-version-check", "wheel", "--no-build-isolation"]
    subprocess.run(
        [*pip, "--no-deps", "--no-index", "--wheel-dir", str(folder), str(folder / "client")], check=True, env=bare()
    )
    return next(folder.glob("ods_client-*-py3-none-any.whl"))


def test_it_is_small_and_typed(wheel: Path) -> None:
    assert wheel.stat().st_size <= MOST_BYTES
    assert "ods/py.typed" in zipfile.ZipFile(wheel).namelist()


def test_it_runs_with_pyzmq_and_msgspec_only(wheel: Path, tmp_path: Path) -> None:
    commands = install(wheel, "ods-client", tmp_path / "venv")
    done = subprocess.run(
        [commands / "python", "-c", PROGRAM, str(tmp_path)], env=bare(), capture_output=True, text=True, check=False
    )
    assert done.stdout.splitlines() == ["tracker: no obstacle list ", "[]"], done.stderr
