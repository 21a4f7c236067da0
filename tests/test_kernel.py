"""Compiled code is never older than the sources of the kernels it was made of."""

import os
import subprocess
import sys
from pathlib import Path

CALLER = """
from ods.kernel import kernel
from callee import inner

@kernel
def outer(x):
    return inner(x) + 1

print(outer(1))
"""
CALLEE = """
from ods.kernel import kernel

@kernel
def inner(x):
    return x * {factor}
"""


def test_a_changed_callee_in_another_file_is_compiled_anew(tmp_path: Path) -> None:
    (tmp_path / "caller.py").write_text(CALLER)
    environment = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    results = []
    for factor in (10, 10, 20):
        (tmp_path / "callee.py").write_text(CALLEE.format(factor=factor))
        command = [sys.executable, str(tmp_path / "caller.py")]
        results.append(subprocess.run(command, env=environment, stdout=subprocess.PIPE, text=True, check=True).stdout)
        assert len(list((tmp_path / "__pycache__").glob("kernels-*"))) == 1
    assert results == ["11\n", "11\n", "21\n"]
