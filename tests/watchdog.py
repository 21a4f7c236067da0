"""Ends a test run that hangs, with the stack of each thread.

pytest-timeout alone does not: its alarm raises an exception in the main thread, once. Where that happens within a
callback of asyncio it is logged and dropped; and after the failure of a test there is no alarm any more while fixtures
are torn down. A thread of C code, which needs no lock of the interpreter, has neither gap.
"""

import faulthandler
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager

import pytest

GRACE_S = 30.0
"""After the time of pytest-timeout, which says more where it works."""
_STDERR = pytest.StashKey[int]()


def pytest_configure(config: pytest.Config) -> None:
    """Keep the terminal, which tests have not."""
    assert sys.__stderr__ is not None
    config.stash[_STDERR] = os.dup(sys.__stderr__.fileno())


def pytest_unconfigure(config: pytest.Config) -> None:
    """Guard the interpreter's end, which waits for threads that tests left behind.

    Not that of xdist's workers: one that has nothing left to do waits for the others, and is ended by xdist.
    """
    if not hasattr(config, "workerinput"):
        faulthandler.dump_traceback_later(GRACE_S, exit=True, file=config.stash[_STDERR])


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> Iterator[None]:
    """Guard the fixtures."""
    with _guarded(item):
        return (yield)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_call(item: pytest.Item) -> Iterator[None]:
    """Guard the test."""
    with _guarded(item):
        return (yield)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_teardown(item: pytest.Item) -> Iterator[None]:
    """Guard what fixtures do at their end."""
    with _guarded(item):
        return (yield)


@contextmanager
def _guarded(item: pytest.Item) -> Iterator[None]:
    limit_s = _limit_s(item)
    if limit_s:
        faulthandler.dump_traceback_later(limit_s + GRACE_S, exit=True, file=item.config.stash[_STDERR])
    try:
        yield
    finally:
        faulthandler.cancel_dump_traceback_later()


def _limit_s(item: pytest.Item) -> float:
    """Return the test's time by pytest-timeout; 0: none."""
    mark = item.get_closest_marker("timeout")
    return float(mark.args[0] if mark and mark.args else item.config.getoption("timeout") or 0.0)
