"""Recordings made of messages, without a bus: a file or a folder as `ods record` writes it."""

from collections.abc import Iterable, Mapping
from pathlib import Path

import msgspec

from ods.base.clock import NS
from ods.messages import Detections, ObstacleList, Ping, Pose, Sector
from ods.recording.mcap.segment import Logged, Segment

OFFSET_NS = 1_700_000_000 * NS
"""UTC less CLOCK_MONOTONIC of these recordings."""
Sample = tuple[str, int, msgspec.Struct]
"""Topic, when it was received (CLOCK_MONOTONIC), message."""


def write_segment(
    path: Path,
    messages: Iterable[Sample],
    *,
    metadata: Mapping[str, str] | None = None,
    attachments: Mapping[str, bytes] | None = None,
    finish: bool = True,
) -> Path:
    """Write one segment; a chunk ends with each ping. Without `finish` it stays as a killed recorder leaves it."""
    segment = Segment(path, OFFSET_NS, {"ods": {"utc_offset_ns": str(OFFSET_NS), **(metadata or {})}})
    for name, data in (attachments or {}).items():
        segment.enclose(name, "application/octet-stream", data, OFFSET_NS)
    for topic, log_ns, message in messages:
        segment.write([Logged(topic, log_ns + OFFSET_NS, msgspec.msgpack.encode(message))])
        if topic == "ping":
            segment.close_chunk()
    segment.finish() if finish else segment.close()
    return path


def small_ping(seq: int, t_ns: int, samples: int = 40) -> Ping:
    """Return a ping of 3 beams whose samples tell its number."""
    data = bytes((seq + n) % 251 for n in range(3 * samples))
    stamps = {"seq": seq, "ping_number": seq, "t_ns": t_ns, "t_rx_ns": t_ns + 1, "utc_ns": t_ns + OFFSET_NS}
    shape = {"beams": 3, "samples": samples, "dtype": "u1", "bearing_rad": [-0.1, 0.0, 0.1]}
    return msgspec.convert(stamps | shape | {"data": data, "range0_m": 1.0, "dr_m": 0.1, "sound_speed": 1500.0}, Ping)


def pose(seq: int, t_ns: int) -> Pose:
    zeros = (0.0, 0.0, 0.0)
    return Pose(seq, t_ns, t_ns + OFFSET_NS, (float(seq), 0.0, 5.0), (1.0, *zeros), zeros, zeros, zeros)


def mission(pings: int, poses_a_ping: int = 15, samples: int = 40, start_ns: int = 1000 * NS) -> list[Sample]:
    """Return what a chain publishes: at each ping some poses before, detections and a list after it."""
    found: list[Sample] = []
    for number in range(pings):
        t_ns = start_ns + number * NS // 7
        for step in range(poses_a_ping):
            at_ns = t_ns - (poses_a_ping - step) * 9_000_000
            found.append(("pose", at_ns + 1_000_000, pose(number * poses_a_ping + step, at_ns)))
        found.append(("ping", t_ns + 200_000, small_ping(number, t_ns, samples)))
        sector = Sector(1.0, 5.0, -0.1, 0.1, 0.1)
        newest = (number + 1) * poses_a_ping - 1
        seen = Detections(number, number, t_ns, t_ns + 1, t_ns + OFFSET_NS, 1500.0, sector, [], poses_until=newest)
        found.append(("detections", t_ns + 300_000, seen))
        picture = ObstacleList(
            number, number, t_ns, t_ns + OFFSET_NS, t_ns + 1, True, [], [], poses_until=newest, made_ns=t_ns + 350_000
        )
        found.append(("obstacles", t_ns + 400_000, picture))
    return found
