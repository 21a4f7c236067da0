"""Output of the bench in the terminal: a live line, then a table."""

import sys

from rich.console import Console
from rich.table import Table

from ods.bench.metrics import Summary
from ods.bench.settings import BenchConfig
from ods.offline.run_record import RunRecord
from ods.offline.score_table import objects_table

PLAIN_EVERY_S = 10
"""Period of the lines where the output is not a terminal, s."""


class ProgressLine:
    """One live line; where the output is no terminal, a line whenever its beginning changes."""

    def __init__(self) -> None:
        self._beginning = ""

    def show(self, text: str) -> None:
        """Replace the line by `text`."""
        if sys.stdout.isatty():
            sys.stdout.write(f"\r\033[K{text[:160]}")
            sys.stdout.flush()
            return
        beginning = text.split(":")[0]
        if text and beginning != self._beginning:
            self._beginning = beginning
            print(text, flush=True)


def state_line(record: RunRecord, elapsed_s: float, seconds: float) -> str:
    """Return the state of a run in one line."""
    step_s = elapsed_s if sys.stdout.isatty() else elapsed_s // PLAIN_EVERY_S * PLAIN_EVERY_S
    if not record.lists:
        return f"{step_s:3.0f} of {seconds:.0f} s: no obstacle list yet"
    newest = record.lists[-1][1]
    states = [obstacle.state for obstacle in newest.obstacles]
    said = "valid" if newest.valid else "NOT VALID: " + "; ".join(newest.reasons)
    return (
        f"{step_s:3.0f} of {seconds:.0f} s: ping {newest.ping_number}, {states.count('active')} active, "
        f"{states.count('stand_by')} stand-by, {states.count('hibernated')} hibernated, {said}"
    )


def show(summary: Summary, settings: BenchConfig) -> None:
    """Print the summary tables and the verdict."""
    console = Console()
    console.print(_figures(summary, settings))
    console.print(objects_table(summary.objects))
    console.print(_processes(summary))
    for name, seconds in summary.back_s.items():
        console.print(f"{name} was killed and restarted after {seconds:.1f} s")
    console.print(f"results: {settings.out}", highlight=False)
    if summary.not_judged:
        line = f"not judged: the machine was busy ({summary.machine}): {'; '.join(summary.not_judged)}"
        console.print(f"[bold yellow]{line}")
    if summary.broken:
        console.print("[bold red]BROKEN: " + "; ".join(summary.broken))
    elif not summary.not_judged:
        console.print("[bold green]all limits hold")
    else:
        console.print("[bold green]all other limits hold")


def _figures(summary: Summary, settings: BenchConfig) -> Table:
    limits = settings.limits
    table = Table("figure", "measured", "limit", title=f"{settings.sim.scene.stem}, {summary.seconds:.0f} s")
    rows: list[tuple[str, str, str]] = [
        ("pings sent", str(summary.pings), ""),
        ("pings lost", str(summary.pings_lost), f"<= {limits.pings_lost}"),
        ("obstacle lists (not valid)", f"{summary.lists} ({summary.invalid_lists})", ""),
        ("longest gap between lists", f"{summary.longest_gap_s:.2f} s", f"<= {limits.longest_gap_s:g} s"),
        ("latency p50, last byte to list", f"{summary.latency_p50_ms:.1f} ms", f"<= {limits.latency_p50_ms:g} ms"),
        ("latency p99", f"{summary.latency_p99_ms:.1f} ms", f"<= {limits.latency_p99_ms:g} ms"),
        ("latency, longest", f"{summary.latency_max_ms:.1f} ms", ""),
        (
            "objects tracked, share of lists",
            f"{summary.tracked_share:.1%}",
            "" if limits.tracked_share is None else f">= {limits.tracked_share:.0%}",
        ),
        (
            "position error, rms",
            f"{summary.position_rms_m:.2f} m",
            "" if limits.position_rms_m is None else f"<= {limits.position_rms_m:g} m",
        ),
        (
            "radius error, largest",
            f"{summary.radius_error:.0%}",
            "" if limits.radius_error is None else f"<= {limits.radius_error:.0%}",
        ),
        ("false tracks", str(summary.false_tracks), "" if limits.false_tracks is None else f"<= {limits.false_tracks}"),
        ("identity switches", str(summary.identity_switches), ""),
        ("computer", f"{summary.machine}, {summary.machine.wake_p95_ms:.1f} ms late (p95)", ""),
    ]
    for row in (*rows, *_avoidance(summary, settings)):
        table.add_row(*row)
    return table


def _avoidance(summary: Summary, settings: BenchConfig) -> list[tuple[str, str, str]]:
    found, limits = summary.avoidance, settings.limits.avoid
    if found is None or limits is None:
        return []
    return [
        ("arrived", f"after {found.seconds:.0f} s" if found.arrived else "no", f"within {settings.seconds:.0f} s"),
        ("least clearance", f"{found.clearance_m:.2f} m ({found.nearest})", f">= {limits.clearance_m:g} m"),
        ("smallest height over the bottom", f"{found.over_bottom_m:.2f} m", f">= {limits.over_bottom_m:g} m"),
        ("path length relative to an all-knowing planner's", f"{found.path_ratio:.3f}", f"<= {limits.path_ratio:g}"),
        ("path length relative to a straight line", f"{found.straight_ratio:.3f}", ""),
        ("evasions", str(found.evasions), ""),
        ("no valid list, stopped", f"{found.not_valid_s:.1f} s, {found.stopped_s:.1f} s", ""),
    ]


def _processes(summary: Summary) -> Table:
    table = Table("process", "CPU % of a core", "memory MB", "starts", "counters")
    for item in summary.processes:
        counters = summary.counters.get(item.name, {})
        table.add_row(
            item.name,
            f"{item.cpu_percent:.1f}",
            f"{item.rss_mb:.0f}",
            str(item.starts),
            "  ".join(f"{key} {value}" for key, value in sorted(counters.items())),
        )
    return table
