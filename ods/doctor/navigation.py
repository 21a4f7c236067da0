"""The navigation source: its files, and, when asked to listen, what it sends."""

import time
from collections import Counter
from collections.abc import Iterator

from ods import clock
from ods.config import OnboardConfig
from ods.doctor import running
from ods.doctor.finding import Finding
from ods.errors import OdsError
from ods.geodesy import LocalFrame
from ods.nav_bridge.can_frame import CanId
from ods.nav_bridge.can_link import CanLink
from ods.nav_bridge.source import PoseSource
from ods.nav_bridge.sources import make_source

PAUSE_S = 0.005


def files(settings: OnboardConfig) -> Iterator[Finding]:
    """Read the source's files and say what it will wait for."""
    subject = f"navigation by {settings.nav.source}"
    try:
        source = _source(settings, Counter())
    except OdsError as error:
        yield Finding("wrong", subject, str(error))
        return
    expected = ", ".join(f"{_name(can_id)} ({what})" for can_id, what in sorted(source.expects().items()))
    yield Finding("good", subject, f"waits for {expected}")


def listen(settings: OnboardConfig, seconds: float) -> Iterator[Finding]:
    """Listen to the bus, without a word, and say what came."""
    subject = f"navigation by {settings.nav.source}"
    can = settings.nav.can
    if can.interface != "socketcan" and running.is_running(settings.bus.run_dir, "nav"):
        yield Finding("note", subject, "not listened to: the nav process has the adapter")
        return
    counters: Counter[str] = Counter()
    try:
        source = _source(settings, counters)
        link = CanLink(can, source.ids, counters, lambda _fd: None, lambda _fd: None)
        heard, poses, faults = _hear(link, source, seconds)
    except OdsError as error:
        yield Finding("wrong", subject, str(error))
        return
    if not heard:
        why = "; ".join(faults) or "the bus is open"
        yield Finding("wrong", subject, f"nothing that it should send came within {seconds:g} s ({why})")
        return
    for can_id, what in sorted(source.expects().items()):
        rate = heard[can_id] / seconds
        level, told = ("good", f"{rate:.1f} Hz") if rate else ("wrong", f"never came within {seconds:g} s")
        yield Finding(level, f"CAN {_name(can_id)}", f"{what}: {told}")  # type: ignore[arg-type]
    trouble = ", ".join(f"{name} {count}" for name, count in sorted(counters.items()) if _tells_trouble(name, count))
    if not poses:
        yield Finding("wrong", subject, f"no pose came of it: {trouble or 'see the lines above'}")
    else:
        yield Finding("good", subject, f"{poses / seconds:.1f} poses/s" + (f"; {trouble}" if trouble else ""))


def _source(settings: OnboardConfig, counters: Counter[str]) -> PoseSource:
    frame = LocalFrame(settings.site.latitude_deg, settings.site.longitude_deg)
    return make_source(settings.nav, frame, lambda _id, _data: None, counters)


def _hear(link: CanLink, source: PoseSource, seconds: float) -> tuple[Counter[CanId], int, list[str]]:
    """Return how often each identifier came, the number of poses, and what is wrong with the interface."""
    heard: Counter[CanId] = Counter()
    poses = 0
    stop_ns = clock.monotonic_ns() + round(seconds * clock.NS)
    try:
        while clock.monotonic_ns() < stop_ns:
            link.tick()
            for frame in link.read():
                heard[CanId(frame.can_id, frame.extended)] += 1
                poses += source.take(frame) is not None
            time.sleep(PAUSE_S)
        return heard, poses, link.problems()
    finally:
        link.close()


def _tells_trouble(name: str, count: int) -> bool:
    return bool(count) and name.startswith(("epoch_", "pdo_", "can_lost", "can_garbage", "heartbeat_bad", "sequence_"))


def _name(can_id: CanId) -> str:
    return f"0x{can_id.number:08X}" if can_id.extended else f"0x{can_id.number:03X}"
