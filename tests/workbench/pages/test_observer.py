"""The observer's menu, without a browser, on a short simulated mission."""

import asyncio
from collections.abc import AsyncIterator, Callable, Iterator
from typing import Any

import pytest
import pytest_asyncio
from nicegui import ui
from nicegui.testing import User

from ods.workbench.model.actions import OpenData, SetSetting, SetView, ShowPing
from ods.workbench.model.state import DataReference, State
from ods.workbench.pages import observer
from ods.workbench.pages.mission.settings import groups
from ods.workbench.pages.parts.reruns import rerun_of
from ods.workbench.session import Session
from ods.workbench.web.views.chart_view import ChartView
from ods.workbench.web.views.plan_view import PlanView
from tests.workbench.engine.test_rerun import START
from tests.workbench.pages.visiting import simulated

pytestmark = pytest.mark.slow


@pytest.fixture
def session() -> Iterator[Session]:
    made = Session(START)
    yield made
    rerun_of(made).close()


@pytest_asyncio.fixture
async def user(session: Session) -> AsyncIterator[User]:
    async with simulated(lambda: observer.build(session)) as visitor:
        await visitor.open("/")
        yield visitor


async def until(met: Callable[[], Any]) -> None:
    for _ in range(25_000):
        if met():
            return
        await asyncio.sleep(0.01)
    raise AssertionError("it did not come to that")


def the(user: User, kind: type[Any]) -> Any:
    (found,) = user.find(kind=kind).elements
    return found


def status(user: User) -> str:
    (label,) = user.find(marker="observer-status").elements
    assert isinstance(label, ui.label)
    return str(label.text)


async def test_a_mission_is_tracked_shown_and_followed(user: User, session: Session) -> None:
    await until(lambda: "mean GOSPA" in status(user))
    assert "2 tracks" in status(user)
    plan, times = the(user, PlanView), the(user, ChartView)
    assert '"truth"' in plan._props["layers"]["ways"]
    session.do(ShowPing(30))
    await until(lambda: "ping 30" in plan._props["title"])
    assert times._props["cursor"] == pytest.approx(30 * 0.14933, abs=0.01)
    rows = [table.rows for table in user.find(kind=ui.table).elements if isinstance(table, ui.table)]
    assert {len(each) for each in rows} >= {2}  # the objects of this ping, the scores
    session.do(SetView("marked_obstacle", 2))
    await until(lambda: "course of track 2 (" in times._props["title"])


async def test_another_observer_tracks_again(user: User, session: Session) -> None:
    await until(lambda: "mean GOSPA" in status(user))
    first = rerun_of(session).result
    session.do(SetSetting("tracker.life.confirm_echoes", 7))
    await until(lambda: rerun_of(session).result is not first)
    await until(lambda: "mean GOSPA" in status(user))
    session.undo()
    await until(lambda: rerun_of(session).progress is None)


async def test_what_was_tracked_before_is_dimmed_where_data_cannot_be(user: User, session: Session) -> None:
    await until(lambda: "mean GOSPA" in status(user))
    plan, times = the(user, PlanView), the(user, ChartView)
    assert plan._props["busy"] == ""
    session.do(OpenData(DataReference(kind="file", path="gone.s7k")))
    await until(lambda: "gone.s7k" in status(user))
    assert {plan._props["busy"], times._props["busy"]} == {"not the newest"}
    session.undo()
    await until(lambda: plan._props["busy"] == "")


async def test_a_click_in_time_goes_to_the_ping(user: User, session: Session) -> None:
    await until(lambda: "mean GOSPA" in status(user))
    listener = next(each for each in the(user, ChartView)._event_listeners.values() if each.type == "pick")
    with the(user, ChartView):
        listener.handler(type("Event", (), {"args": {"x": 3.0}}))
    assert session.state.ping == 20


async def test_without_data_it_says_what_is_needed() -> None:
    session = Session(State())
    async with simulated(lambda: observer.build(session)) as user:
        await user.open("/")
        await user.should_see("No data are open")
    rerun_of(session).close()


async def test_every_setting_of_the_tracker_has_a_row_that_sets_it(user: User, session: Session) -> None:
    paths = {f"{control.path}" for _, controls in groups() for control in controls}
    assert {"observer", "association", "motion.velocity_sigma", "life.silent_s", "planner.lead_times_s"} <= paths
    for path in paths:
        user.find(marker=f"value {path}")
    (choice,) = user.find(marker="value observer").elements
    assert isinstance(choice, ui.select)
    choice.set_value("coupled")
    await until(lambda: session.state.tuning.config.tracker.observer == "coupled")
    (slider,) = user.find(marker="slider life.confirm_echoes").elements
    assert isinstance(slider, ui.slider)
    slider.set_value(0)
    assert session.state.tuning.config.tracker.life.confirm_echoes == 2
    session.undo()
    await until(lambda: slider.value == 1)
    assert session.state.tuning.config.tracker.life.confirm_echoes == 3


async def test_what_cannot_be_set_stays_as_it_was(user: User, session: Session) -> None:
    (field,) = user.find(marker="value life.drop_existence").elements
    assert isinstance(field, ui.number)
    field.set_value(0.995)  # above confirm_existence
    user.find(marker="value life.drop_existence").trigger("change")
    await until(lambda: field.value == 0.4)
    assert session.state.tuning.config.tracker.life.drop_existence == 0.4


async def test_the_mission_is_played_where_it_is_observed(user: User, session: Session) -> None:
    await until(lambda: "mean GOSPA" in status(user))
    await user.should_see("ping 0 of")
    user.find(marker="play").click()
    await until(lambda: session.state.ping >= 2)
    user.find(marker="play").click()
