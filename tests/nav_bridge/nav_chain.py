"""The nav process wired to a simulated INS: in the real work loop, with a real subscriber, on any CAN bus."""

import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any, cast

import can
import zmq

from ods.base import clock
from ods.base.frames.geometry import quat_from_euler
from ods.base.geodesy import SiteSettings
from ods.messages import Health, Pose
from ods.nav_bridge.service import NavWorker
from ods.nav_bridge.settings import CanopenSettings, CanSettings, DbcSettings, NavConfig, NavSettings, NmeaSettings
from ods.runtime import bus, service
from ods.runtime.ending import Stop
from ods.runtime.processes import PROCESSES
from ods.sim_sonar.ins.canopen_ins import SimulatedIns
from ods.sim_sonar.ins.dbc_ins import SimulatedDbcIns

CONFIG = Path(__file__).parents[2] / "config"
EDS = CONFIG / "ins.eds"
MS = 1_000_000
PERIOD_S = 0.01
STEP_M = 0.05
"""North, from instant to instant."""
INS_AHEAD_NS = 40 * clock.NS
"""The INS's clock is wrong; nobody may trust it."""


class Client:
    """What the process published."""

    def __init__(self, context: "zmq.Context[zmq.Socket[bytes]]", run_dir: Path) -> None:
        self.poses: list[Pose] = []
        self.health: Health | None = None
        self._subscriber = bus.Subscriber(context, run_dir, ["pose"], ["nav"])

    def until(self, enough: Callable[[], bool], patience_s: float = 60.0) -> None:
        """Listen until `enough`: a guest kernel without virtualisation starts a process in half a minute."""
        deadline_s = time.monotonic() + patience_s
        while not enough() and time.monotonic() < deadline_s:
            for topic, message in self._subscriber.receive(0.05)[0]:
                if topic == "pose":
                    self.poses.append(message)
                else:
                    self.health = message
        assert enough(), self.health

    def says(self, text: str) -> bool:
        """Tell whether the newest health report has a problem with `text`."""
        return self.health is not None and any(text in problem for problem in self.health.problems)

    def close(self) -> None:
        self._subscriber.close()


SITE = SiteSettings(latitude_deg=57.0, longitude_deg=9.9)


class Vehicle(threading.Thread):
    """The far end: an INS that sends at 100 Hz until reported to stop, and what it sent."""

    def __init__(self, far: can.BusABC, ins: SimulatedDbcIns | None = None) -> None:
        super().__init__(daemon=True)
        self.sent: dict[int, tuple[list[float], list[float], list[float], int]] = {}
        self.mute = False
        self._ins = ins or SimulatedIns(far, EDS)
        self._clock_ns = clock.utc_ns() - clock.monotonic_ns() + INS_AHEAD_NS
        self._stopping = threading.Event()

    def run(self) -> None:
        count = 0
        while not self._stopping.wait(PERIOD_S):
            if not self.mute:
                self._send(count)
                count += 1

    def _send(self, count: int) -> None:
        now_ns = clock.monotonic_ns()
        device_ns = (now_ns + self._clock_ns) // MS * MS
        position = [STEP_M * count, -3.0, 4.0 + 0.001 * count]
        attitude = quat_from_euler(0.1, -0.05, 0.02 * count).tolist()
        velocity = [1.5, 0.001 * count, -0.1]
        self.sent[round(1000 * position[0])] = (position, attitude, velocity, now_ns)
        self._ins.send(device_ns, position, attitude, velocity)

    def close(self) -> None:
        self._stopping.set()
        self.join()


class StopByHand(Stop):
    """Asked by a test: signals are the test runner's, and no business of a thread."""

    def __init__(self) -> None:
        self.asked = False

    def listen(self) -> None:
        """Hear nothing."""


@contextmanager
def nav_process(
    run_dir: Path,
    can_settings: CanSettings,
    dbc: DbcSettings | None = None,
    nmea: NmeaSettings | None = None,
    canopen: CanopenSettings | None = None,
) -> Iterator[tuple[NavWorker, Client]]:
    """Run the worker in the real work loop, in a thread, with a real subscriber."""
    nav = NavSettings(
        source="nmea" if nmea else "dbc" if dbc else "canopen",
        dbc=dbc,
        nmea=nmea,
        canopen=canopen or CanopenSettings(ins_eds=EDS, node_eds=CONFIG / "ods_node.eds", heartbeat_timeout_s=0.5),
        can=can_settings,
        stale_s=0.2,
    )
    host = service.Service(PROCESSES["nav"], run_dir)
    worker = NavWorker(host, NavConfig(nav=nav, site=SITE))
    worker.start()
    stop = StopByHand()
    loop = threading.Thread(target=service._loop, args=(host, cast(Any, worker), stop))
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    client = Client(context, run_dir)
    loop.start()
    try:
        yield worker, client
    finally:
        stop.asked = True
        loop.join()
        worker.stop()
        client.close()
        host.close()
        context.term()


@contextmanager
def wired_up(run_dir: Path, near: CanSettings, far: can.BusABC) -> Iterator[tuple[NavWorker, Client, Vehicle]]:
    """Run the nav process at the near end of a bus and the INS at its far end, which is shut down afterwards."""
    with ExitStack() as stack:
        stack.callback(far.shutdown)
        worker, client = stack.enter_context(nav_process(run_dir, near))
        vehicle = Vehicle(far)
        stack.callback(vehicle.close)
        vehicle.start()
        yield worker, client, vehicle
