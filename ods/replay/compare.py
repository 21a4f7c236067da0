"""Compares reproduced messages with recorded ones, byte by byte or within tolerances."""

import math
from enum import Enum
from typing import NamedTuple

import msgspec

from ods.messages import Detection, Detections, ObstacleList
from ods.replay.rerun import DetectionsPair, ListPair
from ods.runtime.processes import PROCESSES

NEAR_M = 0.05
"""Tolerance of positions, ranges and radii on another type of CPU."""
NEAR_RAD = 0.002
"""Tolerance of bearings on another type of CPU."""
ENOUGH = 0.98
"""Share of messages that must be within the tolerances: a decision at a threshold may differ."""
_ROUNDING = 1e-9
"""Relative: the same sums, put together by the compiler in another order. So much less than any sigma, so much more
than 52 bits leave, that it is no tolerance of results."""

_ENCODER = msgspec.msgpack.Encoder()


class Verdict(Enum):
    """How a message compares with the recorded one."""

    SAME = "identical"
    ROUNDED = "identical except for the last digits"
    SAME_BUT_HEALTH = "identical except for reasons from other processes' health"
    NEAR = "within tolerances"
    OTHER = "different"
    NONE = "not available"


class Compared(NamedTuple):
    """The verdict, and where the first difference is."""

    verdict: Verdict
    where: str = ""


def compare_detections(pair: DetectionsPair) -> Compared:
    """Compare the detections of a ping."""
    if pair.again is None:
        return Compared(Verdict.NONE)
    if _ENCODER.encode(pair.again) == pair.data:
        return Compared(Verdict.SAME)
    if _rounded(pair.recorded, pair.again):
        return Compared(Verdict.ROUNDED)
    where = f"ping {pair.recorded.ping_number}: {_first_difference(pair.recorded, pair.again)}"
    return Compared(Verdict.NEAR if _near_detections(pair.recorded, pair.again) else Verdict.OTHER, where)


def compare_lists(pair: ListPair) -> Compared:
    """Compare a list; one without a ping by its obstacles, as when it was made depends on the clock."""
    original, again = pair.recorded, pair.again
    if again is None:
        return Compared(Verdict.NONE)
    if _ENCODER.encode(again) == pair.data or (original.ping_number < 0 and again.obstacles == original.obstacles):
        return Compared(Verdict.SAME)
    if again.reasons != original.reasons and _of_health(again.reasons) != _of_health(original.reasons):
        judged = msgspec.structs.replace(again, valid=original.valid, reasons=original.reasons)
        if _of_input(again.reasons) == _of_input(original.reasons) and _rounded(original, judged):
            return Compared(Verdict.SAME_BUT_HEALTH)
    if _rounded(original, again) or (original.ping_number < 0 and _rounded(original.obstacles, again.obstacles)):
        return Compared(Verdict.ROUNDED)
    where = f"list {original.seq}: {_first_difference(original, again)}"
    return Compared(Verdict.NEAR if _near_lists(original, again) else Verdict.OTHER, where)


def _of_health(reasons: list[str]) -> list[str]:
    return [reason for reason in reasons if reason.partition(":")[0] in PROCESSES]


def _of_input(reasons: list[str]) -> list[str]:
    return [reason for reason in reasons if reason.partition(":")[0] not in PROCESSES]


def _rounded(original: object, again: object) -> bool:
    """Return whether both say the same, numbers but for rounding."""
    if isinstance(original, float) and isinstance(again, float):
        return math.isclose(original, again, rel_tol=_ROUNDING, abs_tol=_ROUNDING**2)
    if isinstance(original, msgspec.Struct) and type(original) is type(again):
        return all(_rounded(getattr(original, name), getattr(again, name)) for name in original.__struct_fields__)
    if isinstance(original, list | tuple) and isinstance(again, list | tuple):
        return len(original) == len(again) and all(map(_rounded, original, again))
    return original == again


def _near_detections(original: Detections, again: Detections) -> bool:
    return (
        original.usable == again.usable
        and _near_echoes(original.detections, again.detections)
        and _near_echoes(original.faint, again.faint)
    )


def _near_echoes(original: list[Detection], again: list[Detection]) -> bool:
    return len(original) == len(again) and all(
        abs(a.range_m - b.range_m) <= NEAR_M
        and abs(a.radius_m - b.radius_m) <= NEAR_M
        and abs(a.bearing_rad - b.bearing_rad) <= NEAR_RAD
        for a, b in zip(original, again, strict=True)
    )


def _near_lists(original: ObstacleList, again: ObstacleList) -> bool:
    here, there = ({(o.id, o.state): o for o in each.obstacles} for each in (original, again))
    return here.keys() == there.keys() and all(
        abs(o.radius_m - there[key].radius_m) <= NEAR_M
        and all(abs(a - b) <= NEAR_M for a, b in zip(o.position_ned, there[key].position_ned, strict=True))
        for key, o in here.items()
    )


def _first_difference(original: msgspec.Struct, again: msgspec.Struct) -> str:
    """Name the first field that differs, with both values where they are short."""
    for name in original.__struct_fields__:
        a, b = getattr(original, name), getattr(again, name)
        if a == b:
            continue
        if isinstance(a, list) and isinstance(b, list):
            if len(a) != len(b):
                return f"{name}: {len(a)} recorded, {len(b)} now"
            for place, (x, y) in enumerate(zip(a, b, strict=True)):
                if x != y and isinstance(x, msgspec.Struct):
                    return f"{name}[{place}].{_first_difference(x, y)}"
        return f"{name}: {str(a)[:60]} recorded, {str(b)[:60]} now"
    return "the bytes, perhaps of another version's message"
