"""What the live menu lists below its views: processes, bridges, operators' vetoes, and what `ods doctor` finds."""

import asyncio
from datetime import UTC, datetime
from pathlib import Path

from nicegui import ui

from ods.base.clock import NS
from ods.doctor.report import findings
from ods.messages import Health, ObstacleList
from ods.runtime.processes import may_be_on_board
from ods.workbench.engine.live import Live, state_of
from ods.workbench.engine.live_state import BRIDGE, bridges, vetoes
from ods.workbench.pages.parts.tables import table
from ods.workbench.session import Session
from ods.workbench.web.views.plan_view import Area, Circle, Shape

HEALTH = [
    ("process", "process"), ("state", "state"), ("rates", "messages a second"), ("cpu", "CPU, %"),
    ("memory", "memory, MB"), ("counters", "counters that are not 0"),
]  # fmt: skip
BRIDGES = [
    ("bridge", "bridge"), ("state", "state"), ("sent", "lists sent"), ("withheld", "withheld"),
    ("left_out", "obstacles left out"), ("does", "what it does"),
]  # fmt: skip
VETOES = [
    ("number", "veto"), ("what", "names"), ("ignored", "ignored now"), ("who", "who"), ("why", "why"),
    ("until", "until"),
]  # fmt: skip
FINDINGS = [("level", ""), ("subject", "of"), ("text", "finding")]
STATE = """<q-td :props="props" style="min-width: 6em"
    :class="props.row.bad ? 'text-negative' : 'text-positive'">{{ props.value }}</q-td>"""
LEVELS = {"wrong": "✗ wrong", "note": "! note", "good": "✓ good"}
"""The worst first."""


class LiveTables:
    """Tables of one page; that of the processes is built at once, in the current slot."""

    def __init__(self, live: Live) -> None:
        self._live = live
        self._processes = _wrapped("Processes", HEALTH)

    def build_others(self, session: Session) -> None:
        """Build the others."""
        with ui.row().classes("w-full no-wrap gap-2 items-start max-xl:flex-wrap"):
            self._vetoes = _wrapped("Operators' vetoes (made by ods veto)", VETOES).mark("live-vetoes")
            self._bridges = _wrapped("Bridges", BRIDGES).mark("live-bridges")
        Doctor(session, self._live.run_dir)

    def show(self, now_ns: int) -> None:
        """Show what was received until now."""
        live = self._live
        self._processes.rows = [
            _process(process.name, live.health.get(process.name), live.health_age_s(process.name, now_ns))
            for process in may_be_on_board()
            if process.name in live.health or not process.by_configuration
            if not process.name.startswith(BRIDGE)
        ]
        self._bridges.rows = [
            {"bridge": each.name, "state": _signed(each.state, each.bad), "bad": each.bad, "sent": each.sent,
             "withheld": each.withheld, "left_out": each.left_out, "does": each.does}
            for each in bridges(live.health, lambda name: live.health_age_s(name, now_ns))
        ]  # fmt: skip
        self._vetoes.rows = [] if live.obstacles is None else _veto_rows(live.obstacles)


class Doctor:
    """A button, and the findings that it brings."""

    def __init__(self, session: Session, run_dir: Path) -> None:
        self._session, self._run_dir = session, run_dir
        with ui.row().classes("items-center gap-3"):
            self._button = ui.button("Examine", icon="medical_services", on_click=self._examine)
            self._button.props("dense no-caps outline").mark("examine").tooltip(
                "as `ods doctor` does, by the configuration loaded; it does not listen to sonar or INS"
            )
            self._summary = ui.label("ods doctor: configuration, devices, sockets, clock, versions").classes("text-sm")
        self._findings = _wrapped("", FINDINGS, "level").classes("w-full").mark("findings")
        self._findings.row_key = "key"
        self._findings.set_visibility(False)

    async def _examine(self) -> None:
        self._button.disable()
        self._summary.set_text("looking ...")
        try:
            found = await asyncio.to_thread(lambda: list(findings(self._session.loaded.path, run_dir=self._run_dir)))
        except BaseException:
            self._summary.set_text("it came to no end")
            raise
        finally:
            self._button.enable()
        wrong = sum(each.level == "wrong" for each in found)
        said = f"{wrong} wrong" if wrong else "nothing is wrong"
        self._summary.set_text(f"ods doctor, {self._session.loaded.path}: {said} of {len(found)}")
        self._findings.rows = [
            {"key": at, "level": LEVELS[each.level], "bad": each.level == "wrong", "subject": each.subject,
             "text": each.text}
            for at, each in enumerate(sorted(found, key=lambda each: list(LEVELS).index(each.level)))
        ]  # fmt: skip
        self._findings.set_visibility(True)


def veto_shapes(reported: ObstacleList) -> list[Shape]:
    """Return where the vetoes of a list hold."""
    return [
        Area(veto.region.corners_ne, "veto", f"veto {veto.number}", dashed=True)
        if veto.region.centre_ne is None
        else Circle(veto.region.centre_ne, veto.region.radius_m, "veto", f"veto {veto.number}", dashed=True)
        for veto in reported.vetoes
    ]


def _wrapped(title: str, columns: list[tuple[str, str]], coloured: str = "state") -> ui.table:
    """Build a table of words, with the column that is coloured by `bad`."""
    built = table(title, columns, None).props("wrap-cells")
    for column in built.columns:
        column["align"] = "left"
    built.add_slot(f"body-cell-{coloured}", STATE)
    return built


def _veto_rows(reported: ObstacleList) -> list[dict[str, object]]:
    return [
        {
            "number": veto.number,
            "what": veto.what,
            "ignored": ", ".join(map(str, veto.ignored)) or "nothing",
            "who": veto.author,
            "why": veto.reason,
            "until": f"{datetime.fromtimestamp(veto.until_utc_ns / NS, UTC):%H:%M:%S} UTC, {_left(veto.left_s)}",
        }
        for veto in vetoes(reported)
    ]


def _left(left_s: float) -> str:
    minutes, seconds = divmod(max(0, round(left_s)), 60)
    return f"{minutes} min {seconds} s" if minutes else f"{seconds} s"


def _signed(state: str, bad: bool) -> str:
    return ("✗ " if bad else "✓ ") + state


def _process(name: str, report: Health | None, age_s: float | None) -> dict[str, object]:
    state, bad = state_of(report, age_s)
    row: dict[str, object] = {"process": name, "state": _signed(state, bad), "bad": bad}
    if report is not None:
        counters = "  ".join(f"{name} {count}" for name, count in sorted(report.counters.items()) if count)
        rates = "  ".join(f"{topic} {rate:.1f}" for topic, rate in report.rates_hz.items())
        row |= {
            "rates": rates,
            "cpu": f"{report.cpu_percent:.0f}",
            "memory": f"{report.rss_mb:.0f}",
            "counters": counters,
        }
    return row
