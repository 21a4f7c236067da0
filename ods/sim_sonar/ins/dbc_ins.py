"""The simulated vehicle's inertial navigation system that speaks DBC: the messages of config/sbg.dbc, only sent."""

from collections import Counter
from collections.abc import Collection
from pathlib import Path

import can
import cantools
import numpy as np
from cantools.database import Database
from numpy.typing import ArrayLike

from ods.base.frames.geometry import euler_from_quat, rotation_matrix
from ods.base.geodesy import LocalFrame
from ods.sim_sonar.ins.canopen_node import CanEnd
from ods.sim_sonar.ins.sigmas import USUAL_SIGMAS, Sigmas

PREFIX = "SBG_ECAN_MSG_"
CLOCK_SPAN = 1 << 32
FIRST_TICK = CLOCK_SPAN - 10_000_000
"""The clock, us since power-on, starts so near its end that it begins again from 0 after ten seconds."""
SOLUTION_VALID = 0xF4
"""Attitude, heading, velocity and position are valid; full navigation."""
SEND_TIMEOUT_S = 0.05
ALTIMETER = "ALTIMETER"
"""The altimeter's own message, sent if the DBC file has it."""
ALTIMETER_REACH_M = 655.0
ALTIMETER_EVERY = 10
"""at one instant in so many."""


class SimulatedDbcIns:
    """One INS on a CAN bus. It has no clock and no thread: each `send` is one instant of its life.

    Frames that the bus does not take are counted as `unsent` in `counters`.
    """

    def __init__(self, bus: CanEnd, dbc: Path, frame: LocalFrame) -> None:
        self.counters: Counter[str] = Counter()
        self.solution = SOLUTION_VALID
        self._bus = bus
        self._frame = frame
        database = cantools.database.load_file(dbc)
        assert isinstance(database, Database)
        self._database = database
        self._power_on_ns: int | None = None
        self._has_altimeter = any(message.name == ALTIMETER for message in database.messages)
        self._count = 0

    def send(
        self,
        t_device_utc_ns: int,
        position_ned: ArrayLike,
        attitude: ArrayLike,
        velocity_body: ArrayLike,
        sigmas: Sigmas = USUAL_SIGMAS,
        without: Collection[str] = (),
        over_bottom: float | None = None,
    ) -> None:
        """Send status and one pose epoch, and what the altimeter says when that is due.

        `position_ned` (3,) m, `attitude` (4,) quaternion body to north, east, down where it is, `velocity_body` (3,)
        FRD m/s.
        `without`: messages, less PREFIX, that an INS that fails does not send.
        `over_bottom`: height over the bottom, m, None where it has none.
        """
        if self._power_on_ns is None:
            self._power_on_ns = t_device_utc_ns - 1000 * FIRST_TICK
        ticks = (t_device_utc_ns - self._power_on_ns) // 1000 % CLOCK_SPAN
        latitude, longitude, height = (float(x) for x in self._frame.geodetic(position_ned))
        velocity = rotation_matrix(attitude) @ np.asarray(velocity_body, np.float64)
        signals: dict[str, dict[str, float]] = {
            "STATUS_03": {"SOLUTION": self.solution, "HEAVE_STATUS": 0},
            "EKF_INFO": {"TIME_STAMP": ticks},
            "EKF_EULER": _named("ROLL PITCH YAW", euler_from_quat(attitude)),
            "EKF_ORIENTATION_ACC": _named("ROLL_ACC PITCH_ACC YAW_ACC", sigmas.attitude),
            "EKF_POS": {"LATITUDE": latitude, "LONGITUDE": longitude},
            "EKF_ALTITUDE": {"ALTITUDE": height, "UNDULATION": 0.0},
            "EKF_POS_ACC": _named("LATITUDE_ACC LONGITUDE_ACC ALTITUDE_ACC", sigmas.position),
            "EKF_VEL_NED": _named("VELOCITY_N VELOCITY_E VELOCITY_D", velocity),
        }
        for name, values in signals.items():
            if name not in without:
                self._transmit(PREFIX + name, values)
        if self._has_altimeter and self._count % ALTIMETER_EVERY == 0:
            range_m = over_bottom or 0.0
            found = 0.0 < range_m <= ALTIMETER_REACH_M
            self._transmit(ALTIMETER, {"RANGE": range_m if found else 0.0, "STATUS": int(found)})
        self._count += 1

    def _transmit(self, name: str, values: dict[str, float]) -> None:
        layout = self._database.get_message_by_name(name)
        frame = can.Message(
            arbitration_id=layout.frame_id, data=layout.encode(values), is_extended_id=layout.is_extended_frame
        )
        try:
            self._bus.send(frame, timeout=SEND_TIMEOUT_S)
        except can.CanError:
            self.counters["unsent"] += 1


def _named(names: str, values: ArrayLike) -> dict[str, float]:
    return dict(zip(names.split(), np.asarray(values, np.float64).tolist(), strict=True))
