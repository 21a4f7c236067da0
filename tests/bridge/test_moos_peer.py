"""The bridge to MOOS with a real MOOSDB, pShare and pObstacleMgr: alerts come, and end when the bridge falls silent.

See tests/peers/moos.py.
"""

import socket

from tests.bridge import moos_datagrams
from tests.bridge.played import Bridge, bridge, drained, receiver
from tests.bridge.samples import ROCK, SWIMMER
from tests.peers.moos import community, free_port, needs, say

pytestmark = needs("pObstacleMgr")

TICKS = "  AppTick = 10\n  CommsTick = 10"
SAID: dict[str, float | str] = {
    "NAV_X": 20.0,
    "NAV_Y": 100.0,
    "OBM_ALERT_REQUEST": "name=avd,update_var=OBSTACLE_ALERT,alert_range=1000",
}
"""As navigation and BHV_AvoidObstacleV24 do."""


class Manager:
    """What pObstacleMgr says."""

    def __init__(self, peer: socket.socket, into: int) -> None:
        self._peer, self._into = peer, into
        self.alerts: dict[str, str] = {}
        self.resolved: set[str] = set()

    def received(self) -> None:
        """Say what helm and navigation say, and take what has come."""
        for key, value in SAID.items():
            say(self._peer, self._into, key, value)
        for message in map(moos_datagrams.read, drained(self._peer)):
            label = message.text.rpartition("id=")[2]
            if message.key == "OBSTACLE_ALERT":
                self.alerts[label] = message.text
            else:
                self.resolved.add(label)

    def alerted(self, running: Bridge, *labels: str) -> None:
        """Wait for new alerts."""
        self.alerts.clear()

        def all_there() -> bool:
            self.received()
            return self.alerts.keys() >= set(labels)

        running.until(all_there)

    def forgot(self, running: Bridge, label: str) -> None:
        """Wait until an obstacle is forgotten."""

        def gone() -> bool:
            self.received()
            return label in self.resolved

        running.until(gone)


def test_alerts_come_and_end_with_silence() -> None:
    into = free_port(socket.SOCK_DGRAM)
    with (
        receiver() as peer,
        community("pObstacleMgr", TICKS, ["OBSTACLE_ALERT", "OBM_RESOLVED"], into, peer.getsockname()[1]),
        bridge("moos", into) as running,
    ):
        manager = Manager(peer, into)
        running.obstacles = [ROCK, SWIMMER]
        manager.alerted(running, "ods_7", "ods_300")
        assert "vsource=ods" in manager.alerts["ods_7"]
        corner = f"{50.0 + 2.8 / 0.92388:.2f}"  # to the east of the rock: x; as it was computed for test_moos.py
        assert f"{corner},100" in manager.alerts["ods_7"].replace("100.00", "100")

        running.obstacles = [ROCK]
        manager.forgot(running, "ods_300")
        assert "ods_7" not in manager.resolved  # it is sent, and goes on

        running.valid = False
        running.until(lambda: running.says("the list is not valid"))
        manager.forgot(running, "ods_7")

        manager.resolved.clear()
        running.valid = True
        manager.alerted(running, "ods_7")
