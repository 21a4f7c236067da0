"""Epochs to poses: validity, ranges, instant, quaternion."""

import math
from collections import Counter
from collections.abc import Callable

from ods.clock import NS
from ods.geometry import quat_from_euler
from ods.messages import Pose, Quaternion
from ods.nav_bridge.epoch import Epoch
from ods.nav_bridge.ins_clock import InsClock, day_ms
from ods.nav_bridge.settings import LimitSettings

POSE_PARTS = {1: "position", 2: "attitude", 4: "velocity"}
"""Status bits that must be set for a pose to be used."""
TIME_VALID = 8
ANGLE_SLACK_RAD = 1e-3
"""For a right angle that was rounded up."""


class PoseDecoder:
    """Makes a `Pose` of each sound epoch.

    Counts `epoch_invalid` (status bits), `epoch_absurd` (out of range), `epoch_late` (older than the limit),
    `epoch_untimed` (no valid time of day: arrival taken instead), and `ins_clock_wild` and `ins_clock_jumps`, which
    are those of `OffsetEstimator`.
    """

    def __init__(
        self, limits: LimitSettings, clock_jump_s: float, counters: Counter[str], utc_of: Callable[[int], int]
    ) -> None:
        self.not_valid: list[str] = []
        """Parts of the pose that the newest epoch says are not valid."""
        self._limits = limits
        self._counters = counters
        self._utc_of = utc_of
        self._clock = InsClock(round(clock_jump_s * NS))
        self._poses = 0

    def decode(self, epoch: Epoch, instant_ns: int) -> Pose | None:
        """Return the pose, or None; `instant_ns` is taken when the INS tells no valid time."""
        values = epoch.values
        status = int(values["status"])
        self.not_valid = [part for bit, part in POSE_PARTS.items() if not status & bit]
        if self.not_valid:
            self._counters["epoch_invalid"] += 1
            return None
        if not self._is_believable(values):
            self._counters["epoch_absurd"] += 1
            return None
        t_ns = self._instant(epoch, instant_ns)
        if epoch.t_ns - t_ns > self._limits.age_s * NS:
            self._counters["epoch_late"] += 1
            return None
        return self._pose(values, t_ns)

    def _instant(self, epoch: Epoch, instant_ns: int) -> int:
        milliseconds = day_ms(epoch.values["time_ms"]) if "time_ms" in epoch.values else None
        if milliseconds is None or not int(epoch.values["status"]) & TIME_VALID:
            self._counters["epoch_untimed"] += 1
            return instant_ns
        t_ns = self._clock.instant(milliseconds, epoch.t_ns)
        self._counters["ins_clock_jumps"] = self._clock.estimator.jumps
        self._counters["ins_clock_wild"] = self._clock.estimator.wild
        return t_ns

    def _is_believable(self, values: dict[str, float]) -> bool:
        limits = self._limits
        bounds = {
            "north": limits.horizontal_m,
            "east": limits.horizontal_m,
            "roll": math.pi + ANGLE_SLACK_RAD,
            "pitch": math.pi / 2.0 + ANGLE_SLACK_RAD,
            "yaw": 2.0 * math.pi + ANGLE_SLACK_RAD,
            "u": limits.speed,
            "v": limits.speed,
            "w": limits.speed,
        }
        # written so that NaN, which a REAL32 object may carry, fails
        return all(abs(values[name]) <= bound for name, bound in bounds.items()) and (
            -limits.height_m <= values["down"] <= limits.depth_m
        )

    def _pose(self, values: dict[str, float], t_ns: int) -> Pose:
        w, x, y, z = quat_from_euler(values["roll"], values["pitch"], values["yaw"]).tolist()
        attitude: Quaternion = (w, x, y, z)
        horizontal, tilt = values["sigma_horizontal"], values["sigma_tilt"]
        pose = Pose(
            seq=self._poses,
            t_ns=t_ns,
            utc_ns=self._utc_of(t_ns),
            position_ned=(values["north"], values["east"], values["down"]),
            attitude=attitude,
            velocity_body=(values["u"], values["v"], values["w"]),
            sigma_position_ned=(horizontal, horizontal, values["sigma_down"]),
            sigma_attitude=(tilt, tilt, values["sigma_yaw"]),
        )
        self._poses += 1
        return pose
