"""For all tests: kernels as `ods compile` left them, hypothesis the same in CI as here, unknown counters refused."""

import os
from collections.abc import Iterator
from typing import Any

import pytest
from hypothesis import settings

from ods.runtime import counters
from ods.sonar_link.files.decoder import PLUGGED_IN
from ods.sonar_link.registry import PROTOCOLS

os.environ[counters.REFUSE] = "1"  # for the processes that tests start, too

settings.register_profile("ods", deadline=None, derandomize=True)  # no deadline: first calls may compile
settings.load_profile("ods")


@pytest.fixture
def registers() -> Iterator[None]:
    """Registers of parts as they were before the test, when it is over."""
    from ods.tracker.association.registry import ASSOCIATIONS  # slow
    from ods.tracker.observer.registry import OBSERVERS

    tables: list[Any] = [PROTOCOLS, OBSERVERS, ASSOCIATIONS, PLUGGED_IN]
    before = [dict(table) for table in tables]
    yield
    for table, old in zip(tables, before, strict=True):
        table.clear()
        table.update(old)
