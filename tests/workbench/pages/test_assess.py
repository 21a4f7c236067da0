"""The chain at hand comes onto the chart, and a sweep draws its curves, both in the background."""

import pytest
from nicegui import ui

from ods.workbench.engine import assessment
from ods.workbench.engine.background.own_process import whole
from ods.workbench.model import actions as do
from ods.workbench.pages import assess
from ods.workbench.session import Session
from tests.workbench.model.test_history import LAST
from tests.workbench.pages.visiting import until, visiting

HIGH = f"pipeline.stage[{LAST}].high"


@pytest.fixture(autouse=True)
def _little_work(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(assessment, "IMAGES", 2)
    monkeypatch.setattr(assessment, "OTHERS", ("default", "FIR 9"))
    monkeypatch.setattr(assess, "_others", [])


async def test_a_and_b_stand_among_the_others() -> None:
    session = Session()
    async with visiting(session, assess.build) as user:
        (chart,) = user.find(kind=ui.echart, marker="chains").elements
        await until(lambda: "A: this chain" in chart.options["legend"]["data"])
        assert {each["name"] for each in chart.options["series"][0]["data"]} == {"default", "FIR 9"}
        session.do(do.KeepAsB())
        session.do(do.SetSetting(HIGH, 9.0))
        await until(lambda: "B" in chart.options["legend"]["data"])
        await user.should_see("at its own levels")


async def test_a_sweep_draws_found_and_false_alarms() -> None:
    session = Session()
    async with visiting(session, assess.build) as user:
        (chosen,) = user.find(kind=ui.select, marker="swept setting").elements
        chosen.set_value(HIGH)
        (count,) = user.find(kind=ui.number, content="values").elements
        count.set_value(3)
        user.find(marker="sweep").click()
        await user.should_see(kind=ui.echart, marker="sweep chart", retries=600)
        await user.should_see("2 values, and 1 that the setting refuses")
        (chart,) = user.find(kind=ui.echart, marker="sweep chart").elements
        found, false, ms = (each["data"] for each in chart.options["series"])
        wanted = assessment.swept(whole, session.state, HIGH, [9.165, 16.5], 2)  # a third of it is under `low`
        assert wanted is not None
        assert found == [[each.value, round(each.found, 3)] for each in wanted]
        assert false == [[each.value, round(each.false_alarms, 3)] for each in wanted]
        assert all(spent > 0.0 for _, spent in ms)


async def test_a_sweep_of_nothing_is_refused() -> None:
    async with visiting(Session(), assess.build) as user:
        user.find(marker="sweep").click()
        await user.should_see("choose a setting")
