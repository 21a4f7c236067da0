"""Turns messages into s7k records of one file: pings, contacts for obstacles, poses. No clock, no sockets."""

from collections import Counter

import msgspec
import numpy as np

from ods.base.clock import NS
from ods.base.frames.geometry import body_to_polar, euler_from_quat, global_to_body
from ods.base.frames.quaternion import conjugate, product
from ods.base.geodesy import LocalFrame
from ods.messages import Obstacle, ObstacleList, Ping, Pose
from ods.pose.buffer import PoseBuffer, PoseEstimate
from ods.sonar_link.files.s7k.contact import Change, Contact, encode_contact
from ods.sonar_link.files.s7k.pose import POSE_SENSORS, GeodeticPose, encode_pose
from ods.sonar_link.files.s7k.writer import SONAR_DEVICE, S7kWriter

RECORDED_DEVICES = (SONAR_DEVICE, *POSE_SENSORS)
POSE_PERIOD_NS = NS // 20
"""Readers interpolate; at 100 Hz poses would be nine tenths of all records."""
POSES_KEPT = 400
YEAR_2100_NS = 4_102_444_800 * NS
STEP_NS = NS
"""A change of UTC by less is no step."""
MAX_EXTRAPOLATION_S = 0.5


class Recorder:
    """Writes messages in the given order.

    Counters: pings, contacts, poses written (not each pose that came is); lost_pings, lost_poses, lost_lists (of
    obstacles): gaps in their sequences, whoever dropped them; unfit_pings (nothing that s7k can carry), unfit_contacts,
    unfit_poses; contacts_without_pose. Methods raise OSError when the file cannot be written.
    """

    def __init__(self, writer: S7kWriter, frame: LocalFrame) -> None:
        self.counters: Counter[str] = Counter()
        self._writer = writer
        self._frame = frame
        self._poses = PoseBuffer(POSES_KEPT, MAX_EXTRAPOLATION_S)
        self._last_period: int | None = None
        self._last_seq: dict[str, int] = {}
        self._known: dict[int, tuple[str, int]] = {}
        self._ahead_ns: int | None = None
        self._written_ns: int | None = None

    def take(self, message: Ping | ObstacleList | Pose) -> None:
        """Write a message of any topic."""
        utc_ns = self._own_utc(message)
        if isinstance(message, Ping):
            self._take_ping(msgspec.structs.replace(message, utc_ns=utc_ns))
        elif isinstance(message, ObstacleList):
            self._take_obstacles(message, utc_ns)
        else:
            self._take_pose(message, utc_ns)

    def _own_utc(self, message: Ping | ObstacleList | Pose) -> int:
        """Return UTC of a message by that of the first one: times in the file go on evenly, whatever clock steps."""
        ahead_ns = message.utc_ns - message.t_ns
        if self._ahead_ns is None:
            if not 0 <= message.utc_ns < YEAR_2100_NS:
                return message.utc_ns
            self._ahead_ns = ahead_ns
        if isinstance(message, Pose):  # pings bear another clock's UTC
            if self._written_ns is not None and abs(ahead_ns - self._written_ns) > STEP_NS:
                self.counters["utc_steps"] += 1
            self._written_ns = ahead_ns
        return message.t_ns + self._ahead_ns

    def _follow(self, what: str, seq: int) -> bool:
        """Count a gap in a sequence; return whether it restarted, as its publisher did."""
        last = self._last_seq.get(what, seq)
        self._last_seq[what] = seq
        if seq > last + 1:
            self.counters[f"lost_{what}"] += seq - last - 1
        return seq < last

    def _take_ping(self, ping: Ping) -> None:
        self._follow("pings", ping.seq)
        try:
            self._writer.write_ping(ping)
        except (ValueError, ArithmeticError):
            self.counters["unfit_pings"] += 1
        else:
            self.counters["pings"] += 1

    def _take_pose(self, pose: Pose, utc_ns: int) -> None:
        self._follow("poses", pose.seq)
        self._poses.insert(pose)
        period = pose.t_ns // POSE_PERIOD_NS
        if period == self._last_period:
            return
        self._last_period = period
        latitude, longitude, height = self._frame.geodetic(pose.position_ned)
        at_place = conjugate(self._frame.turn_at(pose.position_ned))  # a heading is relative to true north there
        roll, pitch, yaw = euler_from_quat(product(at_place, pose.attitude))
        numbers = (np.radians(latitude), np.radians(longitude), height, roll, pitch, yaw)
        try:
            if not np.isfinite(numbers).all():
                raise ValueError("a pose is not a number")
            frames = encode_pose(GeodeticPose(*map(float, numbers)), utc_ns)
        except (ValueError, ArithmeticError):
            self.counters["unfit_poses"] += 1
            return
        self._writer.write(frames)
        self.counters["poses"] += 1

    def _take_obstacles(self, obstacle_list: ObstacleList, utc_ns: int) -> None:
        if self._follow("lists", obstacle_list.seq):
            self._known.clear()  # another tracker, which may give the same ids again
        changes = [
            (obstacle, change) for obstacle in obstacle_list.obstacles if (change := self._change(obstacle)) is not None
        ]
        if not changes:
            return
        vehicle = self._poses.at(obstacle_list.t_ns)
        if vehicle is None:
            self.counters["contacts_without_pose"] += len(changes)
            return
        for obstacle, change in changes:
            seen_ns = obstacle.last_seen_utc_ns + utc_ns - obstacle_list.utc_ns
            contact = self._contact(obstacle, change, vehicle, (obstacle_list.ping_number, seen_ns))
            self._write_contact(obstacle, contact, utc_ns)

    def _change(self, obstacle: Obstacle) -> Change | None:
        """Return what is new since the last record of an obstacle; None: nothing."""
        known = self._known.get(obstacle.id)
        if obstacle.state == "terminated":
            return Change.DELETED if known else None
        if known is None:
            return Change.CREATED
        return Change.MODIFIED if known != (obstacle.state, obstacle.last_seen_utc_ns) else None

    def _write_contact(self, obstacle: Obstacle, contact: Contact, utc_ns: int) -> None:
        try:
            frame = encode_contact(contact, utc_ns)
        except (ValueError, ArithmeticError):
            self.counters["unfit_contacts"] += 1
            return
        self._writer.write(frame)
        self.counters["contacts"] += 1
        if contact.change is Change.DELETED:
            del self._known[obstacle.id]
        else:
            self._known[obstacle.id] = obstacle.state, obstacle.last_seen_utc_ns

    def _contact(self, obstacle: Obstacle, change: Change, vehicle: PoseEstimate, seen: tuple[int, int]) -> Contact:
        """`seen`: ping number and UTC, ns."""
        latitude, longitude, _ = self._frame.geodetic(obstacle.position_ned)
        body = global_to_body(obstacle.position_ned, vehicle.position_ned, vehicle.attitude)
        range_m, bearing_rad, _ = body_to_polar(body)
        return Contact(
            target_id=obstacle.id,
            ping_number=seen[0],
            seen_utc_ns=seen[1],
            change=change,
            range_m=float(range_m),
            bearing_rad=float(bearing_rad),
            latitude_rad=float(np.radians(latitude)),
            longitude_rad=float(np.radians(longitude)),
            diameter_m=2.0 * obstacle.radius_m,
            classification=obstacle.state,
            description=_describe(obstacle),
        )


def _describe(obstacle: Obstacle) -> str:
    """Return what record 3001 has no field for, in at most 127 characters."""
    north, east, down = obstacle.sigma_position
    v_north, v_east, v_down = obstacle.velocity_ned
    return (
        f"down={obstacle.position_ned[2]:.1f} v={v_north:.2f},{v_east:.2f},{v_down:.2f} "
        f"sigma={north:.1f},{east:.1f},{down:.1f} sr={obstacle.sigma_radius:.1f} "
        f"p={obstacle.existence:.2f} seen={obstacle.times_seen}"
    )
