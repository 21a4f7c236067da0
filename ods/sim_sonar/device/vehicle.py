"""The simulated vehicle on the bench: a CANopen node whose set points it obeys, in its own thread."""

import queue
from pathlib import Path

import numpy as np

from ods.base import clock
from ods.messages import VehicleTruth
from ods.planner.set_point_pdo import pdo_of
from ods.sim_sonar.device.live import Mission
from ods.sim_sonar.ins.canopen_node import OPERATIONAL, CanEnd, CanopenNode
from ods.sim_sonar.scene.settings import VehiclePath
from ods.sim_sonar.settings import SteeredVehicleSettings
from ods.sim_sonar.steered import SteeredVehicle, at_start

STEP_S = 0.02
KEPT = 256
"""States that are remembered: 5 s, more than any image is late."""
LAG_MARGIN_S = 0.05
TRUTH_NS = round(0.05 * clock.NS)
HEARTBEAT_S = 0.2


def steered_of(settings: SteeredVehicleSettings, path: VehiclePath) -> SteeredVehicle:
    """Return the vehicle at its scene's start, before it has received any set point."""
    north, east, _ = path.velocity_ned
    start = at_start(np.radians(path.heading_deg).item(), float(np.hypot(north, east)), path.position_ned or (0, 0, 0))
    return SteeredVehicle(settings.can_do, start, settings.current_m_s, KEPT)


class VehicleNode(CanopenNode):
    """Its autopilot on the CAN bus. Counts `short_set_points`, too."""

    def __init__(self, bus: CanEnd, eds: Path, node_id: int) -> None:
        """Raises OdsError for an EDS file without the RPDO."""
        super().__init__(bus, node_id, HEARTBEAT_S)
        self._pdo = pdo_of(eds, node_id)
        self.deadline_ns = round(self._pdo.deadline_s * clock.NS)

    def set_point(self) -> tuple[float, float, float] | None:
        """Return the newest set point that has come: heading, speed, down; None: none has."""
        newest = None
        for message in self.receive():
            if message.is_extended_id or message.arbitration_id != self._pdo.can_id or self.state != OPERATIONAL:
                continue
            found = self._pdo.decode(bytes(message.data))
            self.counters["short_set_points"] += found is None
            newest = found or newest
        return newest


class LiveVehicle:
    """Moves the vehicle in real time, from mission time 0 on.

    Its state is known some time ahead, as images are made before their echoes are in: a set point acts later by that
    time, as if the autopilot took that time.
    """

    def __init__(self, vehicle: SteeredVehicle, node: VehicleNode, mission: Mission, ping_period_s: float) -> None:
        self.truths: queue.SimpleQueue[VehicleTruth] = queue.SimpleQueue()
        self.stops = 0
        self._vehicle, self._node, self._mission = vehicle, node, mission
        self._lag_s = ping_period_s + LAG_MARGIN_S
        self._received_ns = mission.start_ns
        self._truth_ns = mission.start_ns
        self._seq = 0

    def step(self) -> int:
        """Take set points, go on; return when the next step is due."""
        now_ns = clock.monotonic_ns()
        self._listen(now_ns)
        while self._vehicle.way[-1].t_s < self._mission.seconds(now_ns) + self._lag_s:
            self._vehicle.step(STEP_S)
        del self._vehicle.way[:-1]
        if now_ns >= self._truth_ns:
            self._truth_ns = max(now_ns, self._truth_ns + TRUTH_NS)
            self.truths.put(self._truth(now_ns))
        return now_ns + round(STEP_S * clock.NS)

    def _listen(self, now_ns: int) -> None:
        wanted = self._node.set_point()
        self._node.boot()
        self._node.beat(now_ns)
        if wanted is not None:
            self._received_ns = max(self._received_ns, now_ns)
            self._vehicle.obey(*wanted)
        elif now_ns - self._received_ns > self._node.deadline_ns:
            self.stops += not self._vehicle.stopped
            self._vehicle.stop()

    def _truth(self, now_ns: int) -> VehicleTruth:
        seconds = self._mission.seconds(now_ns)
        north, east, down = self._vehicle.position(seconds).tolist()
        w, x, y, z = self._vehicle.attitude(seconds).tolist()
        v_north, v_east, v_down = self._vehicle.velocity(seconds).tolist()
        self._seq += 1
        return VehicleTruth(
            seq=self._seq - 1,
            t_ns=now_ns,
            scene_s=seconds,
            position_ned=(north, east, down),
            attitude=(w, x, y, z),
            velocity_ned=(v_north, v_east, v_down),
            stopped=self._vehicle.stopped,
        )
