"""An INS that sends its clock first, with the highest identifier, on a real SocketCAN interface."""

import pytest

from ods.nav_bridge.settings import CanSettings
from tests.nav_bridge.test_epoch_on_bus import (  # noqa: F401  # run here with this module's `can_settings`
    far,
    test_a_wrong_order_is_refused_and_said,
    test_each_pose_has_the_clock_of_its_own_instant,
)


@pytest.fixture
def can_settings(vcan0: str) -> CanSettings:
    """vcan0."""
    return CanSettings(channel=vcan0)
