"""The chain at hand comes onto the chart, and a sweep draws its curves, both in the background."""

from typing import Any

import msgspec
import pytest
from nicegui import ui
from nicegui.element import Element

from ods.workbench.engine import assessment
from ods.workbench.engine.background.own_process import whole
from ods.workbench.model import actions as do
from ods.workbench.pages import assess
from ods.workbench.session import Session
from ods.workbench.web.views.chart_view import ChartView
from tests.workbench.model.test_history import LAST
from tests.workbench.pages.visiting import numbers, until, visiting

HIGH = f"pipeline.stage[{LAST}].high"


def curve(chart: Element, label: str) -> dict[str, Any]:
    """Return a curve of that label; none: {}."""
    shown = msgspec.json.decode(chart._props["shown"])
    found = (each for panel in shown.get("panels", ()) for each in panel["curves"] if each["label"] == label)
    return next(found, {})


@pytest.fixture(autouse=True)
def _little_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assessment, "IMAGES", 2)
    monkeypatch.setattr(assessment, "OTHERS", ("default", "FIR 9"))
    monkeypatch.setattr(assess, "_others", [])


async def test_a_and_b_stand_among_the_others() -> None:
    session = Session()
    async with visiting(session, assess.build) as user:
        (chart,) = user.find(kind=ChartView, marker="chains").elements
        await until(lambda: curve(chart, "A: this chain"))
        assert curve(chart, "others")["names"] == ["default", "FIR 9"]
        session.do(do.KeepAsB())
        session.do(do.SetSetting(HIGH, 9.0))
        await until(lambda: curve(chart, "B"))
        await user.should_see("at its own levels")


async def test_a_sweep_draws_found_and_false_alarms() -> None:
    session = Session()
    async with visiting(session, assess.build) as user:
        (chosen,) = user.find(kind=ui.select, marker="swept setting").elements
        chosen.set_value(HIGH)
        (count,) = user.find(kind=ui.number, content="values").elements
        count.set_value(3)
        user.find(marker="sweep").click()
        await user.should_see(kind=ChartView, marker="sweep chart", retries=600)
        await user.should_see("2 values, and 1 that the setting refuses")
        (chart,) = user.find(kind=ChartView, marker="sweep chart").elements
        found, false, ms = (curve(chart, label) for label in ("", "false alarms", "ms"))
        wanted = assessment.swept(whole, session.state, HIGH, [9.165, 16.5], 2)  # a third of it is under `low`
        assert wanted is not None
        assert numbers(found["x"]) == pytest.approx([each.value for each in wanted])
        assert numbers(found["y"]) == pytest.approx([each.found for each in wanted])
        assert numbers(false["y"]) == pytest.approx([each.false_alarms for each in wanted])
        assert all(spent > 0.0 for spent in numbers(ms["y"]))


async def test_a_sweep_of_nothing_is_refused() -> None:
    async with visiting(Session(), assess.build) as user:
        user.find(marker="sweep").click()
        await user.should_see("choose a setting")
