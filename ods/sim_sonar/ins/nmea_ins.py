"""The simulated vehicle's navigation system that speaks text: NMEA 0183 of an INS, PD6 of its Doppler log."""

import math
import operator
from collections.abc import Callable, Collection
from datetime import UTC, datetime
from functools import reduce

import numpy as np
from numpy.typing import ArrayLike

from ods.base.frames.geometry import euler_from_quat
from ods.base.geodesy import LocalFrame
from ods.sim_sonar.ins.sigmas import USUAL_SIGMAS, Sigmas

PORT = "ins"
"""Name of the simulated device in the run folder."""
EVERY = {"PASHR": 1, "GGA": 10, "GST": 10, "TS": 5, "BS": 5, "BD": 5, "ZDA": 100}
"""Each sentence comes at one instant in so many."""
METRE = 1000.0
"""PD6 tells velocities in mm/s."""


class SimulatedNmeaIns:
    """One INS on a line. It has no clock and no thread: each `send` is one instant of its life."""

    def __init__(self, write: Callable[[list[bytes]], object], frame: LocalFrame) -> None:
        """`write`: takes the sentences of an instant."""
        self._write, self._frame = write, frame
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
        """Send the sentences that are due at this instant.

        `position_ned` (3,) m, `attitude` (4,) quaternion body to north, east, down where it is, `velocity_body` (3,)
        FRD m/s.
        `over_bottom`: height over the bottom, m, None where it has none.
        `without`: sentences that one that fails does not send.
        """
        silent = {*without, "BD"} if over_bottom is None else without
        due = [name for name, every in EVERY.items() if self._count % every == 0 and name not in silent]
        self._count += 1
        now = datetime.fromtimestamp(t_device_utc_ns // 1_000_000 / 1000, UTC)
        time = f"{now:%H%M%S}.{now.microsecond // 1000:03d}"
        latitude, longitude, height = (float(x) for x in self._frame.geodetic(position_ned))
        place = f"{_minutes(latitude, 2, 'NS')},{_minutes(longitude, 3, 'EW')}"
        roll, pitch, yaw = np.degrees(euler_from_quat(attitude)).tolist()
        forward, starboard, down = (round(METRE * part) for part in np.asarray(velocity_body, np.float64).tolist())
        north, east, vertical = np.asarray(sigmas.position, np.float64).tolist()
        spread = ",".join(f"{part:.4f}" for part in np.degrees(sigmas.attitude))
        told = {
            "PASHR": f"$PASHR,{time},{yaw % 360.0:.4f},T,{roll:+.4f},{pitch:+.4f},,{spread},1,1",
            "GGA": f"$INGGA,{time},{place},6,10,1.0,{height:.3f},M,0.0,M,,",
            "GST": f"$INGST,{time},1.0,,,,{north:.2f},{east:.2f},{vertical:.2f}",
            "ZDA": f"$INZDA,{time},{now:%d,%m,%Y},00,00",
            "TS": f":TS,{now:%y%m%d%H%M%S}{now.microsecond // 10000:02d},35.0,+10.0,{-height:6.1f},1480.0,000",
            "BS": f":BS,{starboard:+6d},{forward:+6d},{-down:+6d},A",
            "BD": f":BD,,,,{over_bottom or 0.0:.2f},0.2",
        }
        self._write([_ended(told[name]) for name in due])


def _minutes(degrees: float, digits: int, both: str) -> str:
    """Return degrees as dddmm.mmmmmmm and the hemisphere."""
    units = round(abs(degrees) * 60e7)
    whole, rest = divmod(units, 600_000_000)
    return f"{whole:0{digits}d}{rest // 10_000_000:02d}.{rest % 10_000_000:07d},{both[math.copysign(1.0, degrees) < 0]}"


def _ended(text: str) -> bytes:
    """Return the line with its end, and the checksum that NMEA has and PD6 has not."""
    if text.startswith("$"):
        text += f"*{reduce(operator.xor, text[1:].encode()):02X}"
    return text.encode("ascii") + b"\r\n"
