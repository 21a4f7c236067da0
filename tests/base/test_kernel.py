"""Compiled code is never older than the sources of the kernels it was made of."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

CALLER = """
from ods.base.kernel import kernel
from {module} import inner

@kernel
def outer(x):
    return inner(x) + 1

print(outer(1))
"""
CALLEE = """
from ods.base.kernel import kernel

@kernel
def inner(x):
    return x * {factor}
"""


@pytest.mark.parametrize(("caller", "callee"), [("caller", "callee"), ("package.one.caller", "package.two.callee")])
def test_a_changed_callee_is_compiled_anew(tmp_path: Path, caller: str, callee: str) -> None:
    """Whether it stands in another file or in a sibling folder of the same package."""
    _write(tmp_path, caller, CALLER.format(module=callee))
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
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
