"""What a page says while numba compiles."""

import time

import pytest

from ods.workbench.engine.compiling import LONGEST_S, Compiling


def test_it_is_said_while_it_lasts(monkeypatch: pytest.MonkeyPatch) -> None:
    compiling = Compiling()
    assert not compiling.words()
    compiling.take(7, "echo")
    assert compiling.words().endswith("7 kernels so far")
    later = time.monotonic() + LONGEST_S + 1.0
    monkeypatch.setattr(time, "monotonic", lambda: later)
    assert not compiling.words()
