"""The table of `ods assess track`."""

from collections.abc import Sequence

from rich.box import SIMPLE_HEAD
from rich.table import Table

from ods.assess.track.measure import LATENCY_LIMIT_S, RELATIVE_LIMIT, Row

HEADINGS = (
    *(
        "scenario",
        "tracker",
        "GOSPA",
        "ref.",
        "ratio",
        "limit",
        "memory",
        "limit",
        "HOTA",
        "ref.",
        "AssA",
        "IDF1",
        "rmse m",
        "ref.",
        "% range",
        "switches",
    ),
    *("false", "latency s", "ref.", "NEES", "ref.", "band", "ms", "reached"),
)
WORDS = ("scenario", "tracker", "reached")


def table_of(rows: Sequence[Row], seeds: int) -> Table:
    """Return one line for each scenario and tracker."""
    table = Table(
        title=f"means of {seeds} seeds, switches and false tracks of all together; Stone Soup: of the first seed",
        caption=(
            "ref.: knows identities and motion class. GOSPA in view, m; memory: over the reference's. "
            f"Limits for all: error {RELATIVE_LIMIT:.0%} of range, no false track, latency {LATENCY_LIMIT_S} s or ref."
        ),
        box=SIMPLE_HEAD,
        padding=(0, 0, 0, 1),
    )
    for heading in HEADINGS:
        table.add_column(heading, justify="left" if heading in WORDS else "right", no_wrap=heading != "reached")
    before = ""
    for row in rows:
        table.add_row(*_cells(row, row.scenario if row.scenario != before else ""))
        before = row.scenario
    return table


def _cells(row: Row, name: str) -> list[str]:
    limits, missed = row.limits, row.missed()
    low, high = row.nees_band
    verdict = ("[red]not: " + ", ".join(missed) if missed else "[green]yes") if row.ours else ""
    return [
        name,
        row.tracker,
        f"{row.gospa:.3f}",
        f"{row.reference:.3f}",
        f"{row.ratio:.2f}",
        _limit(limits.gospa),
        f"{row.memory:.2f}",
        _limit(limits.memory),
        f"{row.hota:.3f}",
        f"{row.hota_reference:.3f}",
        f"{row.association:.3f}",
        f"{row.idf1:.3f}",
        f"{row.rmse_m:.3f}",
        f"{row.rmse_reference_m:.3f}",
        f"{100.0 * row.relative:.2f}",
        str(row.switches),
        str(row.false_tracks),
        f"{row.latency_s:.2f}",
        f"{row.latency_reference_s:.2f}",
        f"{row.nees:.2f}",
        f"{row.nees_reference:.2f}",
        f"{low:.2f}-{high:.2f}" if limits.consistent else "",
        f"{row.ms:.2f}",
        verdict,
    ]


def _limit(value: float | None) -> str:
    return "" if value is None else f"{value:.2f}"
