"""Checks the navigation source: its files and, with --listen, the received data."""

import select
import time
from collections import Counter
from collections.abc import Iterator
from typing import Any, NamedTuple

import numpy as np

from ods.base import clock
from ods.base.errors import OdsError
from ods.base.frames.geometry import euler_from_quat
from ods.base.geodesy import LocalFrame
from ods.config import OnboardConfig
from ods.doctor import pose_sense
from ods.doctor.finding import Finding
from ods.messages import Pose
from ods.nav_bridge.dbc.source import DbcSource
from ods.nav_bridge.registry import make_link, make_source
from ods.nav_bridge.settings import NavSettings
from ods.nav_bridge.source import PoseSource
from ods.runtime.counters import trouble_names
from ods.runtime.run_dir import is_locked

PAUSE_S = 0.005
SILENT, NEVER = "no CAN frame", "has never come"
"""Of problems: what an INS that is off looks like."""
NO_NAME = "?"
"""Of what comes: no sentence."""
SLOW = 0.9
"""A message that comes less often than this share of the fastest is slow."""


class Received(NamedTuple):
    """What came while listening."""

    items: Counter[str]
    """How often each identifier or sentence came."""
    poses: list[Pose]
    line: list[str]
    """Problems of the interface at the end, in plain words."""
    problems: list[str]
    """Those of the source."""


def files(settings: OnboardConfig) -> Iterator[Finding]:
    """Read the source's files and report the messages that it expects."""
    subject = f"navigation by {settings.nav.source}"
    try:
        source = _source(settings, Counter())
    except OdsError as error:
        yield Finding("wrong", subject, str(error))
        return
    expected = ", ".join(f"{name} ({what})" for name, what in sorted(source.expects().items()))
    yield Finding("good", subject, f"waits for {expected}")
    for objection in source.objections():
        yield Finding("wrong", subject, objection)


def listen(settings: OnboardConfig, seconds: float) -> Iterator[Finding]:
    """Listen to the bus, without a word, and say what came."""
    subject = f"navigation by {settings.nav.source}"
    nav_runs = is_locked(settings.bus.run_dir, "nav")
    if nav_runs and (settings.nav.source == "nmea" or settings.nav.can.interface != "socketcan"):
        yield Finding("note", subject, "no data received: the nav process uses the line")
        return
    counters: Counter[str] = Counter()
    try:
        source = _source(settings, counters)
        received = _hear(settings, source, counters, seconds)
    except OdsError as error:
        yield Finding("wrong", subject, str(error))
        return
    waiting = None if nav_runs else _waiting(subject, settings.nav, source, received)
    if waiting:
        yield waiting
        return
    if not any(received.items[name] for name in source.expects()):
        yield Finding("wrong", subject, _nothing(settings.nav, received, seconds))
        return
    yield from _rates(source, received.items, _own_rhythm(settings.nav, source), seconds)
    if nav_runs:  # its frames are another node's to us, and it reports the rest itself
        received = received._replace(line=[], problems=[])
        counters["own_id_taken"] = 0
    instants = _fastest(source, received.items, _own_rhythm(settings.nav, source))
    yield from _judge(subject, received, counters, instants, seconds, settings.pose.max_extrapolation_s)


def _source(settings: OnboardConfig, counters: Counter[str]) -> PoseSource[Any]:
    frame = LocalFrame(settings.site.latitude_deg, settings.site.longitude_deg)
    return make_source(settings.nav, frame, lambda _id, _data: None, counters)


def _hear(settings: OnboardConfig, source: PoseSource[Any], counters: Counter[str], seconds: float) -> Received:
    """Listen; what was counted before the first pose is the rest of an epoch under way, and forgotten."""
    opened: list[int | None] = [None]
    link = make_link(settings.nav, source, counters, lambda fd: opened.append(fd), lambda _fd: opened.append(None))
    items: Counter[str] = Counter()
    poses: list[Pose] = []
    stop_ns = clock.monotonic_ns() + round(seconds * clock.NS)
    try:
        while clock.monotonic_ns() < stop_ns:
            link.tick()
            for item in link.read(clock.monotonic_ns()):
                items[source.name_of(item)] += 1
                pose = source.take(item)
                if pose is not None:
                    if not poses:
                        counters.clear()
                    poses.append(pose)
            _wait(opened[-1])
        return Received(items, poses, link.problems(), source.problems(clock.monotonic_ns()))
    finally:
        link.close()


def _wait(fd: int | None) -> None:
    """Wait for a frame, PAUSE_S at most."""
    if fd is None:
        time.sleep(PAUSE_S)
    else:
        select.select([fd], [], [], PAUSE_S)


def _own_rhythm(nav: NavSettings, source: PoseSource[Any]) -> set[str]:
    """Return what need not come as often as poses: heartbeat, status, and what is held."""
    if nav.source == "nmea":
        return {what for what in source.expects().values() if "attitude" not in what}
    if nav.source != "dbc" or nav.dbc is None:
        return {"heartbeat"}
    return {*nav.dbc.held, *(item.signal.partition(".")[0] for item in nav.dbc.valid)}


def _waiting(subject: str, nav: NavSettings, source: PoseSource[Any], received: Received) -> Finding | None:
    """Judge an INS that says at most that it waits to be started; None when it says more, or no node would start it."""
    came = {what for name, what in source.expects().items() if received.items[name]}
    if came - {"heartbeat"} or not source.waits_for_start(clock.monotonic_ns()):
        return None
    if nav.canopen is not None and nav.canopen.start_ins:
        found = "waits to be started" if came else "is silent, as if not started"
        advice = "which the nav process does (nav.canopen.start_ins): check its poses while nav runs"
        return Finding("note", subject, f"the INS {found}, {advice}")
    found = "the INS waits to be started: set nav.canopen.start_ins = true, or let another node start it"
    return Finding("wrong", subject, found) if came else None


def _nothing(nav: NavSettings, received: Received, seconds: float) -> str:
    """Return a text that nothing came that a pose is made of, why if that is known, and what came instead."""
    others = ", ".join(sorted(received.items.keys() - {NO_NAME}))
    found = [f"others came: {others}"] if others else []
    causes = [problem for problem in received.problems if problem.endswith("?")] or received.line
    if causes and not any(SILENT in cause for cause in causes):
        return f"no expected data within {seconds:g} s: {'; '.join([*found, *causes])}"
    found = [*received.line, *(problem for problem in received.problems if NEVER not in problem), *found]
    asked = f"is the INS on, connected and set to send, and {_right(nav)} right?"
    return f"no expected data within {seconds:g} s ({'; '.join(found)}): {asked}"


def _right(nav: NavSettings) -> str:
    """Return the keys that decide whether anything is received, with their verb."""
    if nav.nmea is not None and nav.source == "nmea":
        return "is nav.nmea.port" if "://" in nav.nmea.port else "are nav.nmea.port and nav.nmea.baud"
    return f"are bit rate and {'nav.dbc.file' if nav.source == 'dbc' else 'nav.canopen.ins_node_id'}"


def _fastest(source: PoseSource[Any], items: Counter[str], own_rhythm: set[str]) -> int:
    """Return the number of the INS's instants: the count of the most frequent of the messages that each pose needs."""
    return max(items[name] for name, what in source.expects().items() if what not in own_rhythm)


def _rates(source: PoseSource[Any], items: Counter[str], own_rhythm: set[str], seconds: float) -> Iterator[Finding]:
    """Yield how often each expected identifier came."""
    expected = sorted(source.expects().items())
    otherwise = ", or list it in nav.dbc.held" if isinstance(source, DbcSource) else ""
    unusable, fastest = source.unusable(), _fastest(source, items, own_rhythm)
    for name, what in expected:
        subject, rate = f"{source.kind} {name}", items[name] / seconds
        if not rate:
            yield Finding("wrong", subject, f"{what}: never came within {seconds:g} s: switch it on at the INS")
        elif name in unusable:
            yield Finding("wrong", subject, f"{what}: {rate:.1f} Hz, {unusable[name]}")
        elif items[name] < SLOW * fastest and what not in own_rhythm:
            yield Finding("note", subject, f"{what}: {rate:.1f} Hz, others {fastest / seconds:.1f} Hz: a pose needs "
                          f"all of them, so set them to one rate at the INS{otherwise}")  # fmt: skip
        else:
            yield Finding("good", subject, f"{what}: {rate:.1f} Hz")


def _judge(
    subject: str, received: Received, counters: Counter[str], instants: int, seconds: float, bridged_s: float
) -> Iterator[Finding]:
    """Yield how many poses came and what is wrong with them.

    instants: how many there could be. bridged_s: gap between poses that the tracker bridges.
    """
    trouble = [f"{name} {count}" for name, count in sorted(counters.items()) if count and name in trouble_names("nav")]
    if not received.poses:
        stale = [problem for problem in received.problems if problem.startswith("no pose")] or ["no pose"]
        others = [*received.line, *(problem for problem in received.problems if problem not in stale)]
        yield Finding(
            "wrong", subject, "; ".join(stale + (others or trouble))
        )  # what is counted follows from the others
        return
    rate = len(received.poses) / seconds
    if rate * bridged_s < 1.0:
        yield Finding("wrong", subject, f"{rate:.1f} poses/s: the tracker bridges {bridged_s:g} s "
                      "(pose.max_extrapolation_s), so set a higher rate at the INS")  # fmt: skip
    elif len(received.poses) < SLOW * instants:
        lost = 1.0 - len(received.poses) / instants
        yield Finding("note", subject, f"{rate:.1f} poses/s, the newest {_place(received.poses[-1])}: "
            f"{lost:.0%} of the INS's "
                      f"data is lost")  # fmt: skip
    else:
        yield Finding("good", subject, f"{rate:.1f} poses/s, the newest {_place(received.poses[-1])}")
    for problem in (*received.line, *received.problems):
        yield Finding("wrong", subject, problem)
    yield from pose_sense.examine(subject, received.poses)
    if trouble:
        yield _counted(subject, trouble)


def _counted(subject: str, trouble: list[str]) -> Finding:
    return Finding("note", subject, f"{', '.join(trouble)}: see docs/counters/README.md")


def _place(pose: Pose) -> str:
    """Return the pose in words, for signs to be checked by eye."""
    north, east, down = pose.position_ned
    roll, pitch, yaw = (np.degrees(euler_from_quat(pose.attitude)).round(1) + 0.0).tolist()  # no -0.0
    over = "" if pose.altitude_m is None else f", {pose.altitude_m:.1f} m over the bottom"
    return (
        f"north {north:.1f}, east {east:.1f}, down {down:.1f} m{over}, roll {roll:.1f}, pitch {pitch:.1f}, "
        f"yaw {yaw % 360.0:.1f} deg"
    )
