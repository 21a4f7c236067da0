"""For all tests: hypothesis the same in CI as here, unknown counters refused, garbage collected in what is new, and an
end of what hangs."""

import gc
import os
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import settings

from ods.runtime import counters
from ods.sonar_link.files.decoder import PLUGGED_IN
from ods.sonar_link.registry import PROTOCOLS
from tests.watchdog import (  # noqa: F401
    pytest_configure,
    pytest_runtest_call,
    pytest_runtest_setup,
    pytest_runtest_teardown,
    pytest_unconfigure,
)

os.environ[counters.REFUSE] = "1"  # for the processes that tests start, too

settings.register_profile("ods", deadline=None, derandomize=True)  # no deadline: first calls may compile
settings.load_profile("ods")


def pytest_collection_finish() -> None:
    """Keep what was imported out of later garbage collections: NiceGUI's simulated browser calls for two a page."""
    gc.collect()
    gc.freeze()


@pytest.fixture
def registers() -> Iterator[None]:
    """Registers of parts as they were before the test, when it is over."""
    from ods.tracker.association.registry import ASSOCIATIONS  # slow
    from ods.tracker.observer.registry import OBSERVERS
    from ods.tracker.settings import ASSOCIATION_NAMES, OBSERVER_NAMES

    tables: list[Any] = [PROTOCOLS, OBSERVERS, ASSOCIATIONS, PLUGGED_IN, OBSERVER_NAMES, ASSOCIATION_NAMES]
    before = [table.copy() for table in tables]
    yield
    for table, old in zip(tables, before, strict=True):
        table.clear()
        table.update(old)
