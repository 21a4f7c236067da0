"""`ods watch`: a live table of obstacles and health in the terminal."""

import math
from argparse import ArgumentParser, Namespace
from pathlib import Path

import zmq
from rich.console import Console, Group
from rich.live import Live
from rich.table import Table
from rich.text import Text

from ods.base import clock
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.messages import Clearance, Health, ObstacleList
from ods.runtime import bus
from ods.runtime.caution import cautions
from ods.runtime.processes import SUPERVISOR, may_be_on_board

REFRESH_S = 0.25
UNSEEN_SHOWN_S = 1.0


def add_arguments(_parser: ArgumentParser) -> None:
    """It has none of its own."""


def run(args: Namespace) -> None:
    """Show what the processes of a configuration publish until interrupted. Raises OdsError."""
    watch(load(args.config, OnboardConfig).bus.run_dir)


def watch(run_dir: Path) -> None:
    """Show what `run_dir` publishes until interrupted."""
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    names = [*(process.name for process in may_be_on_board()), SUPERVISOR]
    newest: ObstacleList | None = None
    clear: Clearance | None = None
    health: dict[str, Health] = {}
    with (
        bus.Subscriber(context, run_dir, ["obstacles", "clearance"], names) as subscriber,
        Live(console=Console()) as live,
    ):
        while True:
            received, _ = subscriber.receive(REFRESH_S)
            for _, message in received:
                if isinstance(message, Health):
                    health[message.process] = message
                elif isinstance(message, Clearance):
                    clear = message
                else:
                    newest = message
            now_ns = clock.monotonic_ns()
            silent = newest is None or _age_s(newest, now_ns) > bus.TOPICS["obstacles"].stale_s
            hindrance = bus.hindrance(run_dir, "tracker") if silent else ""
            live.update(screen(newest, health, now_ns, hindrance, None if silent else clear))


def screen(
    newest: ObstacleList | None,
    health: dict[str, Health],
    now_ns: int,
    hindrance: str = "",
    clear: Clearance | None = None,
) -> Group:
    """Return what the terminal shows at `now_ns`; `hindrance`: what keeps the list away, after a colon."""
    lines = [_verdict(newest, now_ns, hindrance), *([Text(_ahead(clear))] if clear and clear.pose else [])]
    return Group(*lines, _obstacles(newest), _processes(health, now_ns))


def _ahead(clear: Clearance) -> str:
    """Say how much water is known to be empty straight ahead, and in how many sectors any is."""
    if clear.pose is None or not clear.clear_to_m:
        return ""
    w, x, y, z = clear.pose.attitude
    heading = math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))
    count = len(clear.clear_to_m)
    k = math.floor(heading / (2.0 * math.pi) * count) % count
    known = sum(to > 0.0 for to in clear.clear_to_m)
    ahead = f"from {clear.clear_from_m[k]:.0f} to {clear.clear_to_m[k]:.0f} m" if clear.clear_to_m[k] else "not known"
    return f"clear ahead: {ahead}; something is known in {known} of {count} sectors"


def _age_s(newest: ObstacleList, now_ns: int) -> float:
    """Return how old a list is: that of a ping of a far range is made a second after its transmission."""
    return (now_ns - (newest.made_ns or newest.t_ns)) / clock.NS


def _verdict(newest: ObstacleList | None, now_ns: int, hindrance: str) -> Text:
    if newest is None:
        return Text(f"no obstacle list yet{hindrance}", style="bold red")
    age_s = _age_s(newest, now_ns)
    if age_s > bus.TOPICS["obstacles"].stale_s:
        return Text(f"NOT VALID: no obstacle list for {age_s:.1f} s{hindrance}", style="bold red")
    if not newest.valid:
        return Text("NOT VALID: " + "; ".join(newest.reasons), style="bold red")
    more = f", {newest.left_out} more farther away" if newest.left_out else ""
    said = f"valid, ping {newest.ping_number}, {len(newest.obstacles)} obstacles{more}"
    doubts = cautions(newest)
    return Text("; ".join([said, *doubts]), style="bold yellow" if doubts else "bold green")


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
            item.state if item.unseen_s < UNSEEN_SHOWN_S else f"{item.state}, unseen {item.unseen_s:.0f} s",
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
