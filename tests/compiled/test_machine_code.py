"""Kernels as machine code: the same results as numba's, without numba."""

import os
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from ods.compiled import machine_code

INNER = """
    from typing import NamedTuple
    import numpy as np
    from ods.compiled.kernel import kernel
    from package.numbers import FACTOR

    class Pair(NamedTuple):
        rows: np.ndarray
        number: float

    @kernel
    def inner(x):
        if x < 0.0:
            raise ValueError("below 0")
        return FACTOR * np.sqrt(x)
"""
OUTER = """
    import numpy as np
    from ods.compiled.kernel import kernel
    from package.one.inner import Pair, inner

    @kernel
    def outer(pair, offset):
        rows = np.empty_like(pair.rows)
        for i in range(len(rows)):
            rows[i] = inner(pair.rows[i]) + offset
        return Pair(rows, pair.number + 1.0)
"""
COMPILE = """
    import sys, numpy as np
    from pathlib import Path
    from package.two.outer import outer
    from package.one.inner import Pair
    from ods.compiled import cache_folder
    from ods.compiled.object_code import keep

    outer(Pair(np.arange(4.0), 1.0), 2.0)
    folder = cache_folder.writable_folder(Path(sys.argv[1]))
    keep(folder, "job", None)
"""
RUN = """
    import sys, numpy as np
    from ods.compiled import kernel
    kernel.do_without_numba()
    from package.two.outer import outer
    from package.one.inner import Pair

    print(outer(Pair(np.arange(4.0), 1.0), 2.0))
    print(outer(Pair(np.arange(4.0), 1.0), offset=2.0).number)
    try:
        outer(Pair(np.full(1, -1.0), 1.0), 2.0)
    except ValueError as error:
        print(error)
    print("numba" in sys.modules)
    print(outer(Pair(np.arange(4.0, dtype=np.float32), 1.0), 2.0))
    print("numba" in sys.modules)
"""
RESULT = "Pair(rows=array([ 2.        , 12.        , 16.14213562, 19.32050808]), number=2.0)"
COMPILED_ON_BOARD = "Pair(rows=array([ 2.      , 12.      , 16.142136, 19.320507], dtype=float32), number=2.0)"


@pytest.fixture
def package(tmp_path: Path) -> Path:
    """Return the folder of a package with two kernels in two folders and a constant in a third file."""
    folder = tmp_path / "package"
    for name, text in {"one/inner": INNER, "two/outer": OUTER, "numbers": "FACTOR = 10.0\n"}.items():
        file = folder / f"{name}.py"
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(textwrap.dedent(text))
        (file.parent / "__init__.py").touch()
    return folder


def python(package: Path, program: str, **environment: str) -> list[str]:
    """Return the lines that a program prints, those on standard error last."""
    path = os.pathsep.join((str(package.parent), *filter(None, sys.path)))
    done = subprocess.run(
        [sys.executable, "-c", textwrap.dedent(program), str(package)],
        env=os.environ | {"PYTHONPATH": path} | environment,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    return (done.stdout + done.stderr).splitlines()


def test_machine_code_needs_no_numba(package: Path) -> None:
    """Neither for records in and out nor for an error; for types never met it compiles, callees included, and warns."""
    python(package, COMPILE)
    *results, warning = python(package, RUN)
    assert results == [RESULT, "2.0", "below 0", "False", COMPILED_ON_BOARD, "True"]
    assert "outer is compiled" in warning


@pytest.mark.parametrize("changed", ["numbers", "one/inner"])
def test_machine_code_is_never_older_than_what_went_into_it(package: Path, changed: str) -> None:
    """A constant in a file without a kernel, and a callee."""
    python(package, COMPILE)
    file = package / f"{changed}.py"
    file.write_text(file.read_text().replace("10.0", "20.0").replace("FACTOR *", "2.0 * FACTOR *"))
    lines = python(package, RUN)
    assert lines[0] == "Pair(rows=array([ 2.        , 22.        , 30.28427125, 36.64101615]), number=2.0)"
    assert any("no machine code" in line for line in lines)


def test_machine_code_that_others_can_write_is_not_opened(package: Path) -> None:
    python(package, COMPILE)
    next(package.rglob("machine-code")).chmod(0o666)
    lines = python(package, RUN)
    assert lines[:1] == [RESULT]
    assert any("no machine code" in line for line in lines)


def test_a_rebuilt_python_of_the_same_version_takes_the_same_machine_code(monkeypatch: pytest.MonkeyPatch) -> None:
    before = machine_code.this_computer()
    monkeypatch.setattr(sys, "version", sys.version.replace("(", "(rebuilt the day before, "))
    machine_code.this_computer.cache_clear()
    assert machine_code.this_computer() == before
