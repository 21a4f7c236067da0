"""Obstacles as MAVLink 2, by pymavlink: OBSTACLE_DISTANCE, or OBSTACLE_DISTANCE_3D; one of them, as ArduPilot forgets
those of the one with the other.

ArduPilot takes what is unknown for free (AP_Proximity_MAV.cpp). So where water is not known to be empty, an obstacle is
sent: docs/bridges/mavlink.md has the rule.
"""

import math
from typing import NamedTuple

from pymavlink.dialects.v20 import ardupilotmega as dialect

from ods.base.clock import MS
from ods.base.frames.quaternion import Vector3, conjugate, rotated
from ods.bridge.encoder import Encoded
from ods.bridge.extrapolated_list import ExtrapolatedList
from ods.bridge.json_udp import heading_deg
from ods.bridge.settings import MavlinkSettings
from ods.messages import Clearance, Obstacle

SECTORS = 72
WIDTH_DEG = 360.0 / SECTORS
"""A message's sector k lies around k * WIDTH_DEG, clockwise from the bow."""
UNKNOWN = 65535
LEAST_M = 0.1
"""`min_distance`: what is nearer would not be taken."""
SIGMAS = 2.0
NO_ID = 65535
MOST_MS = 1 << 32
MOST_BYTES = 1400
"""Of a datagram."""


class Sector(NamedTuple):
    """Known distances in one sector relative to the bow, m."""

    body_m: float
    """Nearest obstacle or echo; inf: none."""
    clear_m: float
    """Range to which the water is known to be empty, m; 0: not even near the vehicle."""


class MavlinkEncoder:
    """Lists with their clearance to messages."""

    def __init__(self, settings: MavlinkSettings) -> None:
        self._settings = settings
        self._datagrams: list[bytes] = []
        self._mav = dialect.MAVLink(self, srcSystem=settings.system_id, srcComponent=settings.component_id)
        self._clearance: Clearance | None = None

    def write(self, data: bytes) -> None:
        """Take a message from pymavlink, which numbers them."""
        if not self._datagrams or len(self._datagrams[-1]) + len(data) > MOST_BYTES:
            self._datagrams.append(b"")
        self._datagrams[-1] += bytes(data)

    def take(self, clearance: Clearance) -> None:
        """Keep the clearance of the list that is encoded next."""
        self._clearance = clearance

    def encode(self, extrapolated: ExtrapolatedList) -> Encoded:
        """Return the messages, as many in a datagram as Ethernet takes in one piece."""
        self._datagrams = []
        if self._clearance is None:
            return Encoded([], 0)
        sectors = around_bow(
            self._clearance, heading_deg(extrapolated.pose.attitude), extrapolated.age_s, self._settings.near_m
        )
        distances_m = [reported_m(sector, self._settings) for sector in sectors]
        if self._settings.form == "distance":
            self._send_distances(extrapolated, distances_m)
            return Encoded(self._datagrams, 0)
        nearest = [
            (each, nearest_point(each, extrapolated)) for each in extrapolated.nearest(self._settings.most_obstacles)
        ]
        sent = [(each.id, place) for each, place in nearest if math.hypot(*place) <= self._settings.most_m]
        self._send_points(extrapolated, distances_m, sent)
        return Encoded(self._datagrams, extrapolated.left_out(len(sent)))

    def _send_distances(self, extrapolated: ExtrapolatedList, distances_m: list[float | None]) -> None:
        most_cm = round(self._settings.most_m * 100.0)
        distances = [UNKNOWN if each is None else min(math.floor(each * 100.0), most_cm + 1) for each in distances_m]
        self._mav.send(
            dialect.MAVLink_obstacle_distance_message(
                time_usec=extrapolated.now_ns // 1000,
                sensor_type=dialect.MAV_DISTANCE_SENSOR_ULTRASOUND,
                distances=distances,
                increment=round(WIDTH_DEG),
                min_distance=round(LEAST_M * 100.0),
                max_distance=most_cm,
                increment_f=WIDTH_DEG,
                angle_offset=0.0,
                frame=dialect.MAV_FRAME_BODY_FRD,
            )
        )

    def _send_points(
        self, extrapolated: ExtrapolatedList, distances_m: list[float | None], nearest: list[tuple[int, Vector3]]
    ) -> None:
        """Send obstacles, and what else bounds the known water, as one set: all have one time."""
        time_ms = extrapolated.now_ns // MS % MOST_MS
        heading = math.radians(heading_deg(extrapolated.pose.attitude))
        for number, place in nearest:
            self._send_point(extrapolated, time_ms, number & 0x7FFF, place)
        for number, distance in enumerate(distances_m):
            if distance is not None and distance <= self._settings.most_m:
                azimuth = heading + math.radians(number * WIDTH_DEG)
                level = distance * math.cos(azimuth), distance * math.sin(azimuth), 0.0
                self._send_point(extrapolated, time_ms, NO_ID, level)

    def _send_point(self, extrapolated: ExtrapolatedList, time_ms: int, number: int, place_ned: Vector3) -> None:
        """Send a point, never so near that it would not be taken."""
        scale = max(1.0, 1.01 * LEAST_M / math.hypot(*place_ned))
        x, y, z = rotated(conjugate(extrapolated.pose.attitude), place_ned)
        self._mav.send(
            dialect.MAVLink_obstacle_distance_3d_message(
                time_boot_ms=time_ms,
                sensor_type=dialect.MAV_DISTANCE_SENSOR_ULTRASOUND,
                frame=dialect.MAV_FRAME_BODY_FRD,
                obstacle_id=number,
                x=x * scale,
                y=y * scale,
                z=z * scale,
                min_distance=LEAST_M,
                max_distance=self._settings.most_m,
            )
        )


def around_bow(clearance: Clearance, heading: float, age_s: float, near_m: float) -> list[Sector]:
    """Return the sectors of the message: of each sector of the clearance that it touches the worst.

    The vehicle, and what may have come in, have moved since: distances are shorter by that.
    """
    velocity = clearance.pose.velocity_ned if clearance.pose is not None else (0.0, 0.0, 0.0)
    moved_m = (math.hypot(velocity[0], velocity[1]) + clearance.fastest_m_s) * max(0.0, age_s)
    return [_worst(clearance, _touched(len(clearance.clear_to_m), heading, k), near_m, moved_m) for k in range(SECTORS)]


def _touched(count: int, heading: float, number: int) -> list[int]:
    """Return the sectors of a clearance of `count` that sector `number` around the bow touches."""
    if not count:
        return []
    width = 360.0 / count
    first = math.floor(((number - 0.5) * WIDTH_DEG + heading) / width + 1e-9)
    last = math.ceil(((number + 0.5) * WIDTH_DEG + heading) / width - 1e-9)
    return [k % count for k in range(first, last)]


def _worst(clearance: Clearance, touched: list[int], near_m: float, moved_m: float) -> Sector:
    bodies = [body for k in touched if (body := clearance.nearest_m[k]) is not None]
    begins_near = all(clearance.clear_from_m[k] <= near_m for k in touched)
    clear_m = min((clearance.clear_to_m[k] for k in touched), default=0.0) if begins_near else 0.0
    return Sector(max(0.0, min(bodies, default=math.inf) - moved_m), max(0.0, clear_m - moved_m))


def reported_m(sector: Sector, settings: MavlinkSettings) -> float | None:
    """Return at which distance an obstacle is sent; more than `most_m`: none, it is free; None: not known."""
    body_m = max(LEAST_M, sector.body_m)
    if settings.unknown == "obstacle":
        distance_m = min(body_m, max(sector.clear_m, settings.unknown_m))
    elif math.isfinite(body_m):
        distance_m = min(body_m, max(LEAST_M, sector.clear_m)) if sector.clear_m else body_m
    elif sector.clear_m > settings.most_m:
        distance_m = math.inf
    else:
        return None
    return distance_m if distance_m <= settings.most_m else settings.most_m + 1.0


def nearest_point(obstacle: Obstacle, extrapolated: ExtrapolatedList) -> Vector3:
    """Return the point of an obstacle next to the vehicle, from its origin, NED, m: SIGMAS nearer than its edge.

    Depth is hardly observed, so it is as near in depth, too, as SIGMAS allow.
    """
    place, own = extrapolated.place(obstacle), extrapolated.vehicle()
    north, east, down = (there - here for there, here in zip(place, own, strict=True))
    far_m = math.hypot(north, east)
    sigma = math.hypot(obstacle.sigma_radius, *obstacle.sigma_position[:2])
    edge_m = max(LEAST_M, far_m - obstacle.radius_m - SIGMAS * sigma)
    depth_m = math.copysign(max(0.0, abs(down) - SIGMAS * obstacle.sigma_position[2]), down)
    scale = edge_m / far_m if far_m > 0.0 else 0.0
    return (north * scale, east * scale, depth_m) if scale else (LEAST_M, 0.0, depth_m)
