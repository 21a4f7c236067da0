"""Errors of sonar and INS in a campaign that are not reported to pipeline and tracker."""

import math
from typing import Annotated

import msgspec

from ods.base.clock import NS
from ods.base.frames.mounting import MountingSettings
from ods.base.frames.quaternion import from_euler, product
from ods.base.settings import Settings
from ods.messages import Ping, Pose
from ods.sim_sonar.receiver.blindness import BLINDNESS
from ods.sim_sonar.settings import FaultSettings

Drift = Annotated[float, msgspec.Meta(ge=-10.0, le=10.0)]


class ErrorSettings(Settings, frozen=True):
    """Errors unknown on board. Poses are reported as precise as ever."""

    range_scale: Annotated[float, msgspec.Meta(ge=0.5, le=2.0)] = 1.0
    """Ratio of reported to true ranges, as of a sonar that is set to a wrong sound speed."""
    mounting: MountingSettings | None = None
    """Where the sonar's head really is; none: as `sonar.mounting` of `onboard` says."""
    drift_m_s: tuple[Drift, Drift] = (0.0, 0.0)
    """The INS's place drifts away from the true one: north, east."""
    yaw_drift_deg_s: Drift = 0.0
    """Its heading drifts, degrees a second."""
    fault: tuple[FaultSettings, ...] = ()
    """Of the sonar: those in the image."""

    def __post_init__(self) -> None:
        for place, fault in enumerate(self.fault):
            if fault.kind not in BLINDNESS:
                raise ValueError(f"fault[{place}].kind: {fault.kind} does not apply to images: {', '.join(BLINDNESS)}")

    def ping(self, ping: Ping) -> Ping:
        """Return a ping as the sonar reports it."""
        if self.range_scale == 1.0:
            return ping
        scale = self.range_scale
        return msgspec.structs.replace(
            ping, range0_m=scale * ping.range0_m, dr_m=scale * ping.dr_m, sound_speed=scale * ping.sound_speed
        )

    def pose(self, pose: Pose) -> Pose:
        """Return a pose as the INS reports it."""
        if self.drift_m_s == (0.0, 0.0) and self.yaw_drift_deg_s == 0.0:
            return pose
        t_s, (north, east, down) = pose.t_ns / NS, pose.position_ned
        turn = from_euler(0.0, 0.0, math.radians(self.yaw_drift_deg_s * t_s))
        place = (north + t_s * self.drift_m_s[0], east + t_s * self.drift_m_s[1], down)
        return msgspec.structs.replace(pose, position_ned=place, attitude=product(turn, pose.attitude))

    def faults_at(self, t_s: float) -> list[str]:
        """Return the kinds of the faults at mission time `t_s`."""
        return [fault.kind for fault in self.fault if fault.at_s <= t_s < fault.at_s + fault.for_s]
