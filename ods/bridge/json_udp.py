"""An obstacle list as one JSON object of bounded length: the nearest obstacles, and how many are left out.

Places are NED, m, at the instant `utc_ms` of sending; headings are degrees. docs/bridges/json.md has it all.
"""

import math
from typing import Any

import msgspec

from ods.base.frames.quaternion import Quaternion
from ods.bridge.encoder import Encoded
from ods.bridge.extrapolated_list import ExtrapolatedList
from ods.bridge.settings import JsonSettings
from ods.messages import Obstacle, Outline, UnseenPart

FORMAT = 1
"""Of the datagram; another one when a field changes its meaning."""
MS = 1_000_000
LEFT_OUT = b'"left_out":'
MOST_UNSEEN = 10
"""Most parts of the sector that are reported, so that they never fill a datagram."""


class JsonEncoder:
    """Lists to JSON."""

    def __init__(self, settings: JsonSettings) -> None:
        self._settings = settings

    def encode(self, extrapolated: ExtrapolatedList) -> Encoded:
        """Return one datagram."""
        head = msgspec.json.encode(_head(extrapolated))[:-1] + b',"obstacles":['
        room = self._settings.most_bytes - len(head) - len(b"],") - len(LEFT_OUT) - len(b"1000000}")
        items: list[bytes] = []
        for obstacle in extrapolated.nearest(self._settings.most_obstacles):
            item = msgspec.json.encode(_obstacle(obstacle, extrapolated))
            room -= len(item) + 1
            if room < 0:
                break
            items.append(item)
        left_out = extrapolated.left_out(len(items))
        return Encoded([head + b",".join(items) + b"]," + LEFT_OUT + b"%d}" % left_out], left_out)


def _head(extrapolated: ExtrapolatedList) -> dict[str, Any]:
    obstacle_list, site = extrapolated.obstacle_list, extrapolated.obstacle_list.site
    return {
        "ods": FORMAT,
        "seq": obstacle_list.seq,
        "utc_ms": extrapolated.utc_ns // MS,
        "utc_source": obstacle_list.utc_source,
        "age_s": round(extrapolated.age_s, 3),
        "site": site,
        "frame": obstacle_list.frame,
        "vehicle": {
            "position_ned": _rounded(extrapolated.vehicle()),
            "velocity_ned": _rounded(extrapolated.pose.velocity_ned),
            "heading_deg": round(heading_deg(extrapolated.pose.attitude), 2),
        },
        "bottom_left_out": obstacle_list.bottom_left_out,
        "unseen_share": round(obstacle_list.unseen_share, 3),
        "unseen_why": obstacle_list.unseen_why[:200],
        "unseen": [_unseen(part) for part in obstacle_list.unseen[:MOST_UNSEEN]],
        "caution": obstacle_list.caution[:200],
    }


def _unseen(part: UnseenPart) -> dict[str, Any]:
    """Return a part of the fan in the head's frame, bearing positive to starboard."""
    return {
        "bearing_deg": _rounded((math.degrees(part.bearing_min_rad), math.degrees(part.bearing_max_rad))),
        "range_m": _rounded((part.range_min_m, part.range_max_m)),
        "why": part.why,
    }


def _obstacle(obstacle: Obstacle, extrapolated: ExtrapolatedList) -> dict[str, Any]:
    cpa = obstacle.cpa
    return {
        "id": obstacle.id,
        "state": obstacle.state,
        "distance_m": round(extrapolated.edge_m(obstacle), 3),
        "position_ned": _rounded(extrapolated.place(obstacle)),
        "velocity_ned": _rounded(obstacle.velocity_ned),
        "radius_m": round(obstacle.radius_m, 3),
        "sigma_position": _rounded(obstacle.sigma_position),
        "sigma_velocity": _rounded(obstacle.sigma_velocity),
        "sigma_radius": round(obstacle.sigma_radius, 3),
        "covariance_ne": round(obstacle.covariance_ne, 6),
        "existence": round(obstacle.existence, 3),
        "times_seen": obstacle.times_seen,
        "unseen_s": round(obstacle.unseen_s, 2),
        "bottom_probability": round(obstacle.bottom_probability, 3),
        "moving": round(obstacle.moving, 3),
        "multipath_of": obstacle.multipath_of,
        "ignored": _ignored(obstacle, extrapolated),
        "near_m": _metres(obstacle.near_m),
        "sigma_near_m": _metres(obstacle.sigma_near_m),
        "elongated": round(obstacle.elongated, 3),
        "outline": None if obstacle.outline is None else _outline(obstacle.outline),
        "cpa": None if cpa is None else {
            "time_s": round(extrapolated.approach_s(cpa), 2),
            "distance_m": round(cpa.distance_m, 3),
            "sigma_m": round(cpa.sigma_m, 3),
        },
    }  # fmt: skip


def _ignored(obstacle: Obstacle, extrapolated: ExtrapolatedList) -> dict[str, Any] | None:
    """Return the operator's veto of an obstacle; None: there is none."""
    for veto in extrapolated.obstacle_list.vetoes:
        if veto.number == obstacle.ignored_by:
            return {"by": veto.author, "why": veto.reason, "until_utc_ms": veto.until_utc_ns // MS}
    return None


def _outline(outline: Outline) -> dict[str, Any]:
    return {
        "middle_ne": _rounded(outline.middle_ne),
        "half_length_m": round(outline.half_length_m, 3),
        "half_width_m": round(outline.half_width_m, 3),
        "azimuth_deg": round(math.degrees(outline.azimuth_rad), 2),
        "sigma_half_length_m": round(outline.sigma_half_length_m, 3),
    }


def _metres(value: float | None) -> float | None:
    return None if value is None else round(value, 3)


def heading_deg(attitude: Quaternion) -> float:
    """Return the heading of a body-to-NED attitude (w, x, y, z): clockwise from north, [0, 360)."""
    w, x, y, z = attitude
    return math.degrees(math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))) % 360.0


def _rounded(numbers: tuple[float, ...]) -> list[float]:
    return [round(number, 3) for number in numbers]
