"""The nav process end to end, as in tests/nav_bridge/test_service.py, on a real SocketCAN interface."""

from collections.abc import Iterator

import can
import pytest

from ods.nav_bridge.service import NavWorker
from ods.nav_bridge.settings import CanSettings
from tests.nav_bridge.nav_chain import Client, Vehicle, wired_up
from tests.nav_bridge.test_service import (  # noqa: F401  # run here with this module's `wired`
    test_every_epoch_arrives_as_it_was_sent,
    test_silence_is_reported_while_it_lasts_and_lived_down,
)


@pytest.fixture
def wired(vcan0: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[NavWorker, Client, Vehicle]]:
    """Everything wired up on vcan0."""
    far = can.Bus(vcan0, "socketcan", ignore_config=True)
    with wired_up(tmp_path_factory.mktemp("nav"), CanSettings(channel=vcan0), far) as everything:
        yield everything
