"""The state of the processes as one JSON object: docs/hardware/operation.md has its fields."""

from typing import Any

import msgspec

from ods.base import clock
from ods.commands.watched.received import Received, age_s
from ods.messages import Health
from ods.runtime import bus
from ods.runtime.caution import cautions
from ods.runtime.processes import on_board

FORMAT = 1
"""Of the object; another one when a field changes its meaning."""


def text(received: Received, now_ns: int, unreachable_reason: str = "") -> str:
    """Return the object in one line; a number that is unknown is null.

    unreachable_reason: what keeps the list away, after a colon.
    """
    return msgspec.json.encode(_whole(received, now_ns, unreachable_reason)).decode()


def _whole(received: Received, now_ns: int, unreachable_reason: str) -> dict[str, Any]:
    newest, reasons = received.newest, _reasons(received, now_ns, unreachable_reason)
    return {
        "ods": FORMAT,
        "valid": not reasons,
        "reasons": reasons,
        "cautions": cautions(newest) if newest and not reasons else [],
        "age_s": round(age_s(newest, now_ns), 3) if newest else None,
        "processes": _processes(received.health, now_ns),
        "list": newest,
        "clearance": received.clear,
    }


def _reasons(received: Received, now_ns: int, unreachable_reason: str) -> list[str]:
    """Return why there is no list to be relied on; empty where there is one."""
    if received.newest is None:
        return [f"no obstacle list yet{unreachable_reason}"]
    if received.silent(now_ns):
        return [f"no obstacle list for {age_s(received.newest, now_ns):.1f} s"]
    return [] if received.newest.valid else received.newest.reasons or ["not valid"]


def _processes(health: dict[str, Health], now_ns: int) -> dict[str, Any]:
    """Return those that run on every vehicle, received or not, and whatever else was received."""
    always = [process.name for process in on_board()]
    others = sorted(health.keys() - set(always))
    return {name: _process(health.get(name), now_ns) for name in (*always, *others)}


def _process(health: Health | None, now_ns: int) -> dict[str, Any]:
    if health is None:
        return {"state": "not seen"}
    old_s = (now_ns - health.t_ns) / clock.NS
    state = "silent" if old_s > bus.HEALTH_STALE_S else "ready" if health.ready else "starting"
    return {"state": state, "age_s": round(old_s, 3), **msgspec.structs.asdict(health)}
