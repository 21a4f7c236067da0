"""Tables for pandas and spreadsheets: a folder of CSV files (RFC 4180), a row a thing, times as whole numbers, ns."""

import csv
import json
from collections import Counter
from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path

import msgspec

from ods.messages import Detection, Detections, Health, Obstacle, ObstacleList, Ping, Pose

Cell = str | int | float | bool | None
NED = ("north", "east", "down")

COLUMNS: dict[str, tuple[str, ...]] = {
    "pings": (
        "utc_ns", "t_ns", "seq", "ping_number", "beams", "samples", "planes", "range0_m", "dr_m", "sound_speed",
        "frequency_hz", "setting",
    ),
    "detections": ("utc_ns", "t_ns", "seq", "ping_number", *Detection.__struct_fields__),
    "scans": ("utc_ns", "t_ns", "seq", "ping_number", "detections", "usable", "unseen_share", "unseen_why",
              "heard_from_db", "caution"),
    "lists": (
        "utc_ns", "t_ns", "seq", "ping_number", "valid", "reasons", "obstacles", "left_out", "bottom_left_out",
        "unseen_share", "heard_from_db", "caution",
    ),
    "obstacles": (
        "utc_ns", "t_ns", "list_seq", "valid", "id", "state", *(f"{a}_m" for a in NED), *(f"v_{a}_mps" for a in NED),
        "radius_m", *(f"sigma_{a}_m" for a in NED), *(f"sigma_v_{a}_mps" for a in NED), "sigma_radius_m",
        "covariance_ne_m2", "existence", "times_seen", "unseen_s", "first_seen_utc_ns", "last_seen_utc_ns",
        "cpa_time_s", "cpa_distance_m", "cpa_sigma_m", "bottom_probability", "height_above_bottom_m",
        "sigma_height_above_bottom_m", "moving", "multipath_of", "near_m", "sigma_near_m", "elongated",
        "outline_north_m", "outline_east_m", "half_length_m", "half_width_m", "azimuth_rad", "sigma_half_length_m",
        "ignored_by",
    ),
    "poses": (
        "utc_ns", "t_ns", "seq", *(f"{a}_m" for a in NED), "qw", "qx", "qy", "qz", "v_forward_mps", "v_starboard_mps",
        "v_down_mps", *(f"sigma_{a}_m" for a in NED), "sigma_roll_rad", "sigma_pitch_rad", "sigma_yaw_rad",
        "altitude_m", "sigma_altitude_m", "utc_source",
    ),
    "health": ("utc_ns", "t_ns", "process", "pid", "seq", "ready", "problems", "cpu_percent", "rss_mb", "counters"),
}  # fmt: skip
"""The files, without their ending, and their columns."""


class CsvTables:
    """Writes the tables into a new folder."""

    def __init__(self, folder: Path) -> None:
        """Raises OSError."""
        self.losses: Counter[str] = Counter()
        folder.mkdir()
        self._stack = ExitStack()
        self._tables = {}
        for name, columns in COLUMNS.items():
            file = self._stack.enter_context((folder / f"{name}.csv").open("x", newline="", encoding="utf-8"))
            self._tables[name] = csv.writer(file)
            self._tables[name].writerow(columns)

    def take(self, stamp_ns: int, message: msgspec.Struct) -> None:
        """Write the rows of a message. Raises OSError."""
        for table, row in rows_of(stamp_ns, message):
            self._tables[table].writerow(row)

    def close(self) -> None:
        """Raises OSError."""
        self._stack.close()


def rows_of(stamp_ns: int, message: msgspec.Struct) -> Iterable[tuple[str, tuple[Cell, ...]]]:
    """Yield table and values of each row that a message makes."""
    if isinstance(message, Ping):
        yield "pings", _values(stamp_ns, message, COLUMNS["pings"][1:])
    elif isinstance(message, Detections):
        yield from _detections(stamp_ns, message)
    elif isinstance(message, ObstacleList):
        yield "lists", _list(stamp_ns, message)
        for obstacle in message.obstacles:
            yield "obstacles", (stamp_ns, message.t_ns, message.seq, message.valid, *_obstacle(obstacle))
    elif isinstance(message, Pose):
        yield "poses", _pose(stamp_ns, message)
    elif isinstance(message, Health):
        yield "health", _health(stamp_ns, message)


def _values(stamp_ns: int, message: msgspec.Struct, names: Iterable[str]) -> tuple[Cell, ...]:
    return (stamp_ns, *(getattr(message, name) for name in names))


def _detections(stamp_ns: int, message: Detections) -> Iterable[tuple[str, tuple[Cell, ...]]]:
    head = _values(stamp_ns, message, ("t_ns", "seq", "ping_number"))
    seen = message.unseen_share, message.unseen_why, message.heard_from_db, message.caution
    yield "scans", (*head, len(message.detections), message.usable, *seen)
    for detection in message.detections:
        yield "detections", (*head, *msgspec.structs.astuple(detection))


def _list(stamp_ns: int, message: ObstacleList) -> tuple[Cell, ...]:
    return (
        *_values(stamp_ns, message, ("t_ns", "seq", "ping_number", "valid")),
        "; ".join(message.reasons), len(message.obstacles), message.left_out, message.bottom_left_out,
        message.unseen_share, message.heard_from_db, message.caution,
    )  # fmt: skip


def _obstacle(o: Obstacle) -> tuple[Cell, ...]:
    nearest = (o.cpa.time_s, o.cpa.distance_m, o.cpa.sigma_m) if o.cpa else (None, None, None)
    outline = (None,) * 6 if o.outline is None else (*o.outline.middle_ne, *msgspec.structs.astuple(o.outline)[1:])
    return (
        o.id, o.state, *o.position_ned, *o.velocity_ned, o.radius_m, *o.sigma_position, *o.sigma_velocity,
        o.sigma_radius, o.covariance_ne, o.existence, o.times_seen, o.unseen_s, o.first_seen_utc_ns,
        o.last_seen_utc_ns, *nearest, o.bottom_probability, o.height_above_bottom_m, o.sigma_height_above_bottom_m,
        o.moving, o.multipath_of, o.near_m, o.sigma_near_m, o.elongated, *outline, o.ignored_by,
    )  # fmt: skip


def _pose(stamp_ns: int, p: Pose) -> tuple[Cell, ...]:
    return (
        stamp_ns, p.t_ns, p.seq, *p.position_ned, *p.attitude, *p.velocity_body, *p.sigma_position_ned,
        *p.sigma_attitude, p.altitude_m, p.sigma_altitude_m, p.utc_source,
    )  # fmt: skip


def _health(stamp_ns: int, h: Health) -> tuple[Cell, ...]:
    return (
        stamp_ns, h.t_ns, h.process, h.pid, h.seq, h.ready, "; ".join(h.problems), h.cpu_percent, h.rss_mb,
        json.dumps(h.counters),
    )  # fmt: skip
