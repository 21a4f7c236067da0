"""Obstacles and health as a table in the terminal."""

import math
from collections.abc import Callable, Iterator

from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ods.base import clock
from ods.base.errors import OdsError
from ods.commands.watched.received import Received, age_s
from ods.messages import Clearance, Health, Obstacle, ObstacleList
from ods.runtime import bus
from ods.runtime.caution import cautions
from ods.runtime.processes import may_be_on_board

UNSEEN_SHOWN_S = 1.0


def live(updates: Iterator[Received], hindered: Callable[[], str]) -> None:
    """Show what is received, at each update; hindered: says what keeps the list away. Raises OdsError."""
    console = Console()
    if not console.is_terminal:  # which would stay empty until the end
        raise OdsError("the live table needs a terminal: use --once, or --once --json")
    with Live(console=console) as table:
        for received in updates:
            table.update(screen_of(received, hindered))


def once(received: Received, hindered: Callable[[], str]) -> None:
    """Print it once."""
    Console().print(screen_of(received, hindered))


def screen_of(received: Received, hindered: Callable[[], str]) -> Group:
    """Return what the terminal shows of it now."""
    now_ns = clock.monotonic_ns()
    silent = received.silent(now_ns)
    unreachable_reason = hindered() if silent else ""
    return screen(received.newest, received.health, now_ns, unreachable_reason, None if silent else received.clear)


def screen(
    newest: ObstacleList | None,
    health: dict[str, Health],
    now_ns: int,
    unreachable_reason: str = "",
    clear: Clearance | None = None,
) -> Group:
    """Return what the terminal shows at `now_ns`; `unreachable_reason`: what keeps the list away, after a colon."""
    lines = [_verdict(newest, now_ns, unreachable_reason), *([Text(_ahead(clear))] if clear and clear.pose else [])]
    return Group(*lines, _obstacles(newest), _processes(health, now_ns))


def _ahead(clear: Clearance) -> str:
    """Return how much water is known to be empty straight ahead, and in how many sectors any is."""
    if clear.pose is None or not clear.clear_to_m:
        return ""
    w, x, y, z = clear.pose.attitude
    heading = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    count = len(clear.clear_to_m)
    k = math.floor(heading / (2.0 * math.pi) * count) % count
    known = sum(to > 0.0 for to in clear.clear_to_m)
    ahead = f"from {clear.clear_from_m[k]:.0f} to {clear.clear_to_m[k]:.0f} m" if clear.clear_to_m[k] else "not known"
    return f"clear ahead: {ahead}; water is known in {known} of {count} sectors"


def _verdict(newest: ObstacleList | None, now_ns: int, unreachable_reason: str) -> Text:
    if newest is None:
        return Text(f"no obstacle list yet{unreachable_reason}", style="bold red")
    old_s = age_s(newest, now_ns)
    if old_s > bus.TOPICS["obstacles"].stale_s:
        return Text(f"NOT VALID: no obstacle list for {old_s:.1f} s{unreachable_reason}", style="bold red")
    if not newest.valid:
        return Text("NOT VALID: " + "; ".join(newest.reasons), style="bold red")
    more = f", {newest.left_out} more farther away" if newest.left_out else ""
    said = f"valid, ping {newest.ping_number}, {len(newest.obstacles)} obstacles{more}"
    objections = cautions(newest)
    return Text("; ".join([said, *objections]), style="bold yellow" if objections else "bold green")


def _obstacles(newest: ObstacleList | None) -> Table:
    table = Table(
        "id", "state", "north m", "east m", "down m", "speed m/s", "radius m", "nearest m, in s", "exists", "seen"
    )
    for column in table.columns:
        column.justify = "right"
    for item in newest.obstacles if newest else []:
        north, east, down = item.position_ned
        sigma = item.sigma_position
        speed = (item.velocity_ned[0] ** 2 + item.velocity_ned[1] ** 2) ** 0.5
        table.add_row(
            str(item.id),
            _state(item),
            f"{north:.1f} ±{sigma[0]:.1f}",
            f"{east:.1f} ±{sigma[1]:.1f}",
            f"{down:.1f} ±{sigma[2]:.1f}",
            f"{speed:.2f}",
            f"{item.radius_m:.1f} ±{item.sigma_radius:.1f}",
            f"{item.cpa.distance_m:.1f} ±{item.cpa.sigma_m:.1f}, {item.cpa.time_s:.0f}" if item.cpa else "",
            f"{item.existence:.2f}",
            str(item.times_seen),
        )
    return table


def _state(item: Obstacle) -> str:
    unseen = f", unseen {item.unseen_s:.0f} s" if item.unseen_s >= UNSEEN_SHOWN_S else ""
    return item.state + unseen + (", ignored" if item.ignored_by >= 0 else "")


def _processes(health: dict[str, Health], now_ns: int) -> Table:
    table = Table("process", "state", "rates Hz", "CPU %", "MB", "counters")
    for process in may_be_on_board():
        item = health.get(process.name)
        if item is None and process.by_configuration:
            continue
        if item is None:
            table.add_row(process.name, Text("not seen", style="red"))
            continue
        age_s = (now_ns - item.t_ns) / clock.NS
        if age_s > bus.HEALTH_STALE_S:
            state = Text(f"silent for {age_s:.0f} s", style="bold red")
        elif item.problems:
            state = Text("; ".join(item.problems), style="yellow")
        else:
            state = Text("ready" if item.ready else "starting", style="green" if item.ready else "yellow")
        table.add_row(
            process.name,
            state,
            "  ".join(f"{topic} {rate:.1f}" for topic, rate in item.rates_hz.items()),
            f"{item.cpu_percent:.0f}",
            f"{item.rss_mb:.0f}",
            "  ".join(f"{name} {count}" for name, count in sorted(item.counters.items()) if count),
        )
    return table
