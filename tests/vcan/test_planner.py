"""The planner's process as in tests/planner/test_service.py, on a real SocketCAN interface."""

from collections.abc import Iterator

import can
import pytest

from tests.planner.played import PlayedPlanner, played_planner
from tests.planner.test_service import (  # noqa: F401  # run here with this module's `wired`
    test_it_is_silent_until_it_knows_where_it_is_and_on_can_once_it_has_arrived,
    test_set_points_follow_lists_on_both_buses,
)


@pytest.fixture
def wired(vcan0: str) -> Iterator[tuple[PlayedPlanner, can.BusABC]]:
    with can.Bus(vcan0, "socketcan", ignore_config=True) as bus, played_planner("socketcan", vcan0) as running:
        yield running, bus
