"""The image processing menu without a browser: what a slider, the list of stages and B do to state and picture."""

import asyncio
from collections.abc import AsyncIterator, Callable
from functools import partial
from typing import Any

import msgspec
import pytest
import pytest_asyncio
from nicegui import ui
from nicegui.outbox import Outbox
from nicegui.testing import User

from ods.offline.mission import MissionSettings
from ods.workbench.engine.data import Data
from ods.workbench.engine.mission.rerun import wanted
from ods.workbench.model.actions import (
    AddStage,
    KeepAsB,
    RemoveStage,
    SetBookmark,
    SetSetting,
    SetTuning,
    SetView,
    ShowPing,
)
from ods.workbench.model.state import DataReference, State, Tuning
from ods.workbench.pages import processing
from ods.workbench.pages.parts.reruns import rerun_of
from ods.workbench.pages.ping import work as processing_work
from ods.workbench.session import Session
from ods.workbench.web.frames import Frame, FrameBoard
from ods.workbench.web.views.chart_view import ChartView
from ods.workbench.web.views.fan_view import FanView
from tests.workbench.engine.test_ping_analysis import pings
from tests.workbench.pages.test_observer_views import tracked
from tests.workbench.pages.visiting import simulated

STAGES: list[dict[str, Any]] = [
    {"use": "equalize.mean_range"},
    {"use": "filter.fir"},
    {"use": "detect.two_level", "follow": 0.0},
]


@pytest.fixture
def session(monkeypatch: pytest.MonkeyPatch) -> Session:
    made = pings(3)
    made[2] = msgspec.structs.replace(made[2], ping_number=4)  # one is missing
    monkeypatch.setattr(processing_work, "open_data", lambda reference, *_: Data(reference, made))
    config = msgspec.convert({"pipeline": {"stage": STAGES}}, MissionSettings)
    return Session(State(Tuning(config=config), data=DataReference(kind="file", path="made up")))


@pytest_asyncio.fixture
async def user(session: Session) -> AsyncIterator[User]:
    async with simulated(lambda: processing.build(session)) as visitor:
        await visitor.open("/")
        yield visitor


def frame(user: User, view: str = "main") -> Frame | None:
    fan = next(iter(user.find(FanView).elements))
    board = fan._channel.source
    assert isinstance(board, FrameBoard)
    return board.latest(view)


def titles(user: User) -> list[str]:
    return [str(fan.props.get("title")) for fan in user.find(FanView).elements]


def kinds(user: User) -> set[str]:
    shown = frame(user)
    return {circle.kind for circle in shown.circles} if shown else set()


async def until(true: Callable[[], Any]) -> Any:
    """Wait until something is so, and return it."""
    for _ in range(12_000):
        if value := true():
            return value
        await asyncio.sleep(0.02)
    raise AssertionError("it never came")


def widget(user: User, marker: str) -> Any:
    (found,) = user.find(marker=marker).elements
    return found


def scrub(user: User, place: int, *, held: bool = True) -> None:
    user.find(marker="ping").trigger("scrub", {"place": place, "held": held})


def shows(user: User, place: int) -> bool:
    shown = frame(user)
    return shown is not None and shown.caption.startswith(f"ping {place},")


def stages(session: Session) -> list[str]:
    return [str(stage["use"]) for stage in session.state.tuning.config.pipeline.chain()]


async def test_a_slider_changes_the_state_and_the_picture(user: User, session: Session) -> None:
    first = await until(lambda: frame(user))
    assert "detection" in first.caption
    slider = widget(user, "slider high")
    slider.set_value(slider.value + 20)
    value = session.state.tuning.config.pipeline.chain()[2]["high"]
    assert value == pytest.approx(8.0)
    newer = await until(lambda: frame(user) if frame(user) is not first else None)
    assert newer.version > first.version
    await until(lambda: widget(user, "value high").value == pytest.approx(8.0))
    session.undo()
    await until(lambda: widget(user, "value high").value == 6.0)


async def test_an_invalid_value_says_its_line_and_changes_nothing(user: User, session: Session) -> None:
    before = session.state.tuning
    field = widget(user, "value low")
    field.set_value(11.0)
    user.find(marker="value low").trigger("change")
    await user.should_see("low: 11.0 is above high, 6.0")
    assert session.state.tuning == before
    assert field.value == 2.5


async def test_a_field_that_is_emptied_shows_the_value_that_is(user: User, session: Session) -> None:
    before = session.state.tuning
    await until(lambda: widget(user, "columns").text)  # all rows are shown anew when the first picture is there
    field = widget(user, "value high")
    field.set_value(None)
    user.find(marker="value high").trigger("change")
    await until(lambda: field.value == 6.0)
    assert session.state.tuning == before


async def test_numbers_that_follow_are_shown_as_they_run_and_stay_when_one_is_set(user: User, session: Session) -> None:
    shown = (await until(lambda: frame(user))).caption
    await until(lambda: widget(user, "columns").text.startswith("columns of 2 samples; "))
    field = widget(user, "value min_cells")
    assert field.value == 2
    field.set_value(3)
    user.find(marker="value min_cells").trigger("change")
    chain = session.state.tuning.config.pipeline.chain()
    assert chain[0] == STAGES[0] | {"window": 80}
    assert chain[1] == STAGES[1] | {"taps": 5, "cutoff": pytest.approx(0.2)}
    assert chain[2] == STAGES[2] | {"min_cells": 3}
    assert session.state.tuning.config.pipeline.attention.subsample == 2
    assert session.history.undoes == "detect.two_level: fewest cells 2 → 3"
    await until(lambda: widget(user, "columns").text == "")
    session.undo()
    session.undo()
    await until(lambda: field.value == 2)
    assert session.state.tuning.config.pipeline.chain() == tuple(STAGES)
    await until(lambda: (now := frame(user)) is not None and now.caption == shown)


async def test_stages_are_added_moved_bypassed_and_removed(user: User, session: Session) -> None:
    await until(lambda: frame(user))
    user.find(marker="add filter.median").click()
    assert stages(session) == ["equalize.mean_range", "filter.fir", "filter.median", "detect.two_level"]
    await until(lambda: user.find(marker="earlier 2").elements)
    user.find(marker="earlier 2").trigger("click.stop")
    assert stages(session)[1:3] == ["filter.median", "filter.fir"]
    await asyncio.sleep(0.1)
    widget(user, "runs 0").set_value(False)
    assert session.state.tuning.bypassed == (0,)
    await asyncio.sleep(0.1)
    user.find(marker="remove 1").trigger("click.stop")
    assert stages(session) == ["equalize.mean_range", "filter.fir", "detect.two_level"]
    user.find(marker="add detect.one_level").click()
    assert stages(session)[-1] == "detect.one_level"
    assert session.history.undoes == "detect by detect.one_level"


async def test_b_is_kept_and_its_difference_is_reported(user: User, session: Session) -> None:
    await until(lambda: frame(user))
    user.find(marker="keep as B").click()
    assert session.state.other == session.state.tuning
    session.do(SetSetting("pipeline.stage[2].high", 80.0))
    await until(lambda: frame(user, "beside"))
    session.do(SetView("comparison", "difference"))
    await until(lambda: kinds(user) == {"only_b"})
    user.find(marker="swap").click()
    await until(lambda: kinds(user) == {"only_a"})


async def test_three_filters_are_seen_on_one_beam(user: User, session: Session) -> None:
    await until(lambda: frame(user))
    session.do(KeepAsB())
    await user.should_see(marker="keep as next")
    for name in ("filter.wiener", "filter.median"):
        session.do(RemoveStage(1))
        session.do(AddStage(name, 1))
        if name == "filter.wiener":
            user.find(marker="keep as next").click()
    chosen = widget(user, "profiles")
    await until(lambda: len(chosen.value) == 4)
    names = [chosen.options[each] for each in chosen.value]
    assert names == ["A: as recorded", "A: after 2 filter.median", "B: after 2 filter.fir", "C: after 2 filter.wiener"]
    user.find(marker="drop B").click()
    await until(lambda: [chosen.options[each] for each in chosen.value] == ["as recorded", "after 3 detect.two_level"])


async def test_the_picture_beside_says_which_stage_it_is_after(user: User, session: Session) -> None:
    session.do(SetView("compared_stage", 0))  # the first, not the recorded image
    await until(lambda: "after 1 equalize.mean_range" in titles(user))
    session.do(SetView("compared_stage", -1))
    await until(lambda: "as recorded" in titles(user))


async def test_dragging_a_level_changes_its_setting(user: User, session: Session) -> None:
    await until(lambda: frame(user))
    levels = await until(
        lambda: [
            line
            for view in user.find(ChartView).elements
            for panel in msgspec.json.decode(view._props["shown"]).get("panels", ())
            for line in panel["lines"]
        ]
    )
    high = next(line["value"] for line in levels if line["name"] == "high")
    view = widget(user, "histogram")
    for listener in view._event_listeners.values():
        if listener.type == "drag":
            view._handle_event({"listener_id": listener.id, "args": {"name": "high", "value": high + 2.0}})
    assert session.state.tuning.config.pipeline.chain()[2]["high"] > 6.5


async def test_the_timeline_shows_another_ping(user: User, session: Session) -> None:
    await until(lambda: frame(user))
    scrub(user, 2, held=False)
    assert session.state.ping == 2
    await user.should_see("ping 2 of 3", retries=50)
    session.do(ShowPing(0))
    await until(lambda: widget(user, "ping").place == 0)


async def test_pictures_of_a_timeline_that_is_dragged_cost_no_message_and_all_is_reported_at_the_end(
    user: User, monkeypatch: pytest.MonkeyPatch
) -> None:
    await user.should_see(marker="mark gap 2", retries=5000)
    await until(lambda: "ms" in widget(user, "cost").content)
    sent: list[object] = []
    monkeypatch.setattr(processing, "BESIDE_HELD_S", 3600.0)  # longer than the drag
    scrub(user, 1)
    monkeypatch.setattr(Outbox, "enqueue_update", lambda _, element: sent.append(element))
    monkeypatch.setattr(Outbox, "enqueue_message", lambda *message: sent.append(message))
    for place in (0, 2, 1, 2, 0, 2) * 3:
        scrub(user, place)
        await until(partial(shows, user, place))
    await asyncio.sleep(2.0 * processing_work.REST_S)  # the cost would be reported by now
    assert sent == []
    scrub(user, 2, held=False)
    await user.should_see("ping 2 of 3", retries=50)
    assert widget(user, "ping").place == 2
    await until(lambda: widget(user, "cost") in sent)


async def test_what_a_stage_complains_of_is_one_line_and_the_page_goes_on(user: User, session: Session) -> None:
    await until(lambda: frame(user))
    wrong = msgspec.convert({"pipeline": {"stage": STAGES[:2]}}, MissionSettings)
    session.do(SetTuning(Tuning(config=wrong), "wrong"))
    await user.should_see("exactly the last stage must be one that detects", retries=100)
    session.undo()
    await until(lambda: not widget(user, "trouble").text)


async def test_keys_go_from_ping_to_ping_and_play(user: User, session: Session) -> None:
    await user.should_see("ping 0 of 3", retries=5000)
    press(user, "ArrowRight")
    assert session.state.ping == 1
    press(user, "ArrowRight", shift=True)
    assert session.state.ping == 2
    press(user, "ArrowLeft", shift=True)
    assert session.state.ping == 0
    widget(user, "speed").set_value(20.0)
    press(user, " ")
    await until(lambda: session.state.ping > 0)
    press(user, " ")


def press(user: User, key: str, *, shift: bool = False) -> None:
    pressed = {"action": "keydown", "repeat": False, "altKey": False, "ctrlKey": False, "metaKey": False}
    arguments = {**pressed, "shiftKey": shift, "key": key, "code": key, "location": 0}
    user.find(kind=ui.keyboard).trigger("key", arguments)


async def test_n_goes_from_mark_to_mark(user: User, session: Session) -> None:
    await user.should_see(marker="mark gap 2", retries=5000)
    session.do(SetBookmark(1, "echo"))
    await user.should_see(marker="mark bookmark 1", retries=5000)
    for expected in (1, 2, 2):  # the last stays
        press(user, "n")
        assert session.state.ping == expected
    press(user, "N", shift=True)
    assert session.state.ping == 1


async def test_marks_of_the_timeline_go_to_their_pings(user: User, session: Session) -> None:
    await user.should_see(marker="mark gap 2", retries=5000)
    session.do(SetBookmark(1, "echo"))
    await user.should_see(marker="mark bookmark 1", retries=5000)
    user.find(marker="mark bookmark 1").click()
    assert session.state.ping == 1
    user.find(marker="mark gap 2").click()
    assert session.state.ping == 2
    rerun = rerun_of(session)
    rerun.result, rerun.result_of = tracked({4: {1: "active"}}), wanted(session.state)
    session.do(SetBookmark(1, ""))
    await user.should_see(marker="mark new 1", retries=5000)
    user.find(marker="mark new 1").click()
    assert session.state.ping == 1
    user.find(marker="mark lost 2").click()
    assert session.state.ping == 2
    rerun.close()
