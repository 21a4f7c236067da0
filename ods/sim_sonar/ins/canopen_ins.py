"""The simulated vehicle's inertial navigation system: a CANopen node that sends its pose as its EDS says."""

import struct
from collections.abc import Iterable
from pathlib import Path

import canopen
import numpy as np
from canopen.objectdictionary import SIGNED_TYPES
from canopen.pdo import PdoVariable
from numpy.typing import ArrayLike

from ods.base.clock import DAY_MS, MS, NS
from ods.base.frames.geometry import euler_from_quat
from ods.sim_sonar.ins.canopen_node import OPERATIONAL, CanEnd, CanopenNode
from ods.sim_sonar.ins.sigmas import USUAL_SIGMAS, Sigmas

SYNC, TIME, EMCY = 0x080, 0x100, 0x080
TIME_OF_DAY = struct.Struct("<IH")
STATUS_ALL_VALID = 0b1111
"""Position, attitude, velocity and time of day are valid."""
OVER_BOTTOM_VALID = 0b10000
DAYS_1970_TO_1984 = 5113


class SimulatedIns(CanopenNode):
    """One INS on a CAN bus. It has no clock and no thread: each `send` is one instant of its life."""

    def __init__(self, bus: CanEnd, eds: Path, node_id: int = 5, heartbeat_period_s: float = 0.2) -> None:
        super().__init__(bus, node_id, heartbeat_period_s)
        self.status = STATUS_ALL_VALID
        self._second = -1
        self._sequence = 0
        node = canopen.LocalNode(node_id, str(eds))
        canopen.Network()[node_id] = node
        node.tpdo.read(from_od=True)  # type: ignore[no-untyped-call]
        self._pdos = [pdo for pdo in node.tpdo.values() if pdo.enabled]

    def send(
        self,
        t_device_utc_ns: int,
        position_ned: ArrayLike,
        attitude: ArrayLike,
        velocity_body: ArrayLike,
        sigmas: Sigmas = USUAL_SIGMAS,
        only: Iterable[int] | None = None,
        over_bottom: float | None = None,
    ) -> None:
        """Send SYNC and one pose epoch, and heartbeat and TIME when due.

        `t_device_utc_ns`: the INS's own clock, whole milliseconds (the protocol cuts off the rest). `position_ned` (3,)
        m, `attitude` (4,) quaternion body to north, east, down where it is, `velocity_body` (3,)
        FRD m/s.
        `over_bottom`: height over the bottom, m, None where it has none; told if the EDS has 0x2014.
        `only`: numbers, from 1, of the PDOs to send, for an INS that fails in mid-epoch.
        """
        for _ in self.receive():
            pass
        self.boot()
        time_of_day = TIME_OF_DAY.pack(
            t_device_utc_ns // MS % DAY_MS, t_device_utc_ns // MS // DAY_MS - DAYS_1970_TO_1984
        )
        self._send_periodic(t_device_utc_ns, time_of_day)
        if self.state != OPERATIONAL:
            return
        self.transmit(SYNC, b"")
        objects = _objects(position_ned, attitude, velocity_body, sigmas)
        objects[0x2001, 0] = self.status if over_bottom is None else self.status | OVER_BOTTOM_VALID
        objects[0x2014, 0] = over_bottom or 0.0
        self._fill(objects, time_of_day)
        wanted = None if only is None else set(only)
        for number, pdo in enumerate(self._pdos, 1):
            if wanted is None or number in wanted:
                self.transmit(pdo.cob_id or 0, bytes(pdo.data))
        self._sequence += 1

    def emergency(self, code: int, register: int = 1, data: bytes = b"") -> None:
        """Send an EMCY message; code 0 resets."""
        self.transmit(EMCY + self.node_id, struct.pack("<HB5s", code, register, data))

    def _send_periodic(self, t_ns: int, time_of_day: bytes) -> None:
        self.beat(t_ns)
        if t_ns // NS != self._second:
            self._second = t_ns // NS
            self.transmit(TIME, time_of_day)

    def _fill(self, objects: dict[tuple[int, int], float], time_of_day: bytes) -> None:
        for pdo in self._pdos:
            for variable in pdo.map:
                where = (variable.index, variable.subindex)
                if where == (0x2000, 0):
                    variable.raw = self._sequence % (1 << variable.length)
                elif where == (0x2002, 0):
                    variable.data = time_of_day
                else:
                    _write(variable, objects[where])


def _objects(
    position: ArrayLike, attitude: ArrayLike, velocity: ArrayLike, sigmas: Sigmas
) -> dict[tuple[int, int], float]:
    """Return physical values by object index and sub-index of config/ins.eds."""
    sigma_north, sigma_east, sigma_down = np.asarray(sigmas.position, np.float64).tolist()
    sigma_roll, sigma_pitch, sigma_yaw = np.asarray(sigmas.attitude, np.float64).tolist()
    told = [max(sigma_north, sigma_east), sigma_down, max(sigma_roll, sigma_pitch), sigma_yaw]
    records: dict[int, list[float]] = {
        0x2010: np.asarray(position, np.float64).tolist(),
        0x2011: [float(angle) for angle in euler_from_quat(attitude)],
        0x2012: np.asarray(velocity, np.float64).tolist(),
        0x2013: told,
    }
    return {(index, sub): value for index, values in records.items() for sub, value in enumerate(values, 1)}


def _write(variable: PdoVariable, value: float) -> None:
    """Write `value`, in the EDS's unit, as the nearest count that the variable holds."""
    signed = variable.od.data_type in SIGNED_TYPES
    low, high = (
        (-(1 << variable.length - 1), (1 << variable.length - 1) - 1) if signed else (0, (1 << variable.length) - 1)
    )
    variable.raw = min(max(round(value / variable.od.factor), low), high)
