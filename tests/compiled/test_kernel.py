"""Compiled code is never older than the sources of the kernels it was made of."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

CALLER = """
from ods.compiled.kernel import kernel
from {module} import inner

@kernel
def outer(x):
    return inner(x) + 1

print(outer(1))
"""
CALLEE = """
from ods.compiled.kernel import kernel

@kernel
def inner(x):
    return x * {factor}
"""


@pytest.mark.parametrize(("caller", "callee"), [("caller", "callee"), ("package.one.caller", "package.two.callee")])
def test_a_changed_callee_is_compiled_anew(tmp_path: Path, caller: str, callee: str) -> None:
    """Whether it stands in another file or in a sibling folder of the same package."""
    _write(tmp_path, caller, CALLER.format(module=callee))
    environment = dict(os.environ)
    environment["PYTHONPATH"] = os.pathsep.join(filter(None, sys.path))
    results = []
    for factor in (10, 10, 20):
        _write(tmp_path, callee, CALLEE.format(factor=factor))
        command = [sys.executable, "-m", caller]
        done = subprocess.run(command, env=environment, cwd=tmp_path, stdout=subprocess.PIPE, text=True, check=True)
        results.append(done.stdout)
        assert len(list(tmp_path.rglob("__pycache__/kernels-*"))) == 1
    assert results == ["11\n", "11\n", "21\n"]


def _write(root: Path, module: str, text: str) -> None:
    """Write a module's file, and the packages that it lies in."""
    *packages, name = module.split(".")
    folder = root
    for package in packages:
        folder /= package
        folder.mkdir(exist_ok=True)
        (folder / "__init__.py").touch()
    (folder / f"{name}.py").write_text(text)


def test_without_a_folder_kernels_are_compiled_in_memory_and_that_is_said_once(tmp_path: Path) -> None:
    """The package is not to be written, as others could write it too, and there is no home."""
    _write(tmp_path, "package.callee", CALLEE.format(factor=10))
    _write(tmp_path, "package.caller", CALLER.format(module="package.callee"))
    (tmp_path / "package").chmod(0o777)
    environment = {"PYTHONPATH": os.pathsep.join(filter(None, sys.path)), "PATH": os.environ["PATH"]}
    command = [sys.executable, "-m", "package.caller"]
    done = subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert done.stdout == "11\n"
    assert done.stderr.count("set ODS_CACHE_DIR") == len(done.stderr.splitlines()) == 1
    environment["ODS_CACHE_DIR"] = str(tmp_path / "cache")
    subprocess.run(command, env=environment, cwd=tmp_path, capture_output=True, check=True)
    assert list((tmp_path / "cache").rglob("*.nbc"))
