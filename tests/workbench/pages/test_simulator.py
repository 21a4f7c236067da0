"""The simulator's menu: what is clicked and dragged changes the scene, and what the scene is shows."""

import asyncio
import json
from pathlib import Path
from typing import Any

import pytest
from nicegui import ui
from nicegui.testing import User

from ods.base.files.shipped import FOLDER
from ods.sim_sonar.by_name import find_scene
from ods.workbench.engine.files.openable import opening
from ods.workbench.model import actions as do
from ods.workbench.model.scene.effects import EFFECTS, is_on
from ods.workbench.pages import simulator
from ods.workbench.session import Session
from ods.workbench.web.views.fan_view import FanView
from ods.workbench.web.views.plan_view import PlanView
from tests.workbench.pages.visiting import until, visiting

pytestmark = pytest.mark.slow


@pytest.fixture
def session(tmp_path: Path) -> Session:
    """With figure 11 open, 4 s of it."""
    session = Session(folders=(tmp_path,))
    session.do(opening(FOLDER / "scenes" / "figure11.toml", ()))
    session.do(do.SetScene("duration_s", 4.0))
    return session


SWITCHED = ("image.speckle", "image.belts", "sea_bed.rough")


def one(user: User, marker: str) -> Any:
    (element,) = user.find(marker=marker).elements
    return element


def layer(user: User, name: str) -> list[dict[str, Any]]:
    (plan,) = user.find(kind=PlanView).elements
    shapes: list[dict[str, Any]] = json.loads(plan._props["layers"].get(name, "[]"))
    return shapes


def scene(session: Session) -> Any:
    assert session.state.scene is not None
    return session.state.scene


async def test_without_a_scene_one_is_offered() -> None:
    session = Session()
    async with visiting(session, simulator.build) as user:
        await user.should_see("No scene is open")
        one(user, "open scene").set_value("worked_example.toml")
        await until(lambda: session.state.scene is not None)
        assert scene(session) == find_scene("worked_example").file
        await user.should_see(kind=PlanView)
        await until(lambda: [each for each in layer(user, "scene") if each.get("label") == "object 2"])


async def test_plan_and_clock_show_the_ping(session: Session) -> None:
    async with visiting(session, simulator.build) as user:
        await until(lambda: layer(user, "scene"))
        assert {each["label"] for each in layer(user, "scene") if each["role"] == "object"} == {"near", "far", "port"}
        one(user, "ping").set_value(7)
        await until(lambda: one(user, "clock").text.startswith("ping 7 of 26"))
        assert session.state.ping == 7


async def test_a_field_that_is_emptied_or_refused_shows_what_is(session: Session) -> None:
    session.do(do.AddWaypoint("vehicle", 1.0, (0.3, 0.0, 20.0)))
    async with visiting(session, simulator.build) as user:
        await until(lambda: layer(user, "scene"))
        time, seed = one(user, "vehicle.waypoints[1].t_s"), one(user, "seed")
        was = time.value
        for value in (None, -1.0):
            time.set_value(value)
            user.find(marker="vehicle.waypoints[1].t_s").trigger("blur")
            await until(lambda: time.value == was)
        seed.set_value(None)
        user.find(marker="seed").trigger("blur")
        await until(lambda: seed.value == scene(session).seed)


async def test_nothing_is_simulated_while_the_menu_is_hidden(session: Session) -> None:
    """And what was missed is made up for when it is shown again."""
    panels: list[ui.column] = []

    def build(session: Session) -> None:
        with ui.column() as panel:
            simulator.build(session)
        panels.append(panel)

    async with visiting(session, build) as user:
        await until(lambda: layer(user, "scene"))
        clock = one(user, "clock")
        shown = clock.text
        panels[0].set_visibility(False)
        for ping in (3, 5, 7):
            session.do(do.ShowPing(ping))
            await asyncio.sleep(0.1)
        assert clock.text == shown
        panels[0].set_visibility(True)
        await until(lambda: clock.text.startswith("ping 7 of 26"))


async def test_a_slider_changes_the_scene_and_undo_brings_the_slider_back(session: Session) -> None:
    async with visiting(session, simulator.build) as user:
        await until(lambda: layer(user, "scene"))
        one(user, "part").set_value("objects[0]")
        slider = one(user, "slider objects[0].radius_m")
        slider.set_value(78)
        await until(lambda: scene(session).objects[0].radius_m == 4.0)
        await until(lambda: one(user, "value objects[0].radius_m").value == 4.0)
        session.undo()
        await until(lambda: slider.value == 28)
        assert scene(session).objects[0].radius_m == 1.5


async def test_typing_a_value_beyond_the_slider_keeps_it(session: Session) -> None:
    async with visiting(session, simulator.build) as user:
        one(user, "part").set_value("objects[0]")
        one(user, "value objects[0].radius_m").set_value(12.0)
        user.find(marker="value objects[0].radius_m").trigger("change")
        await until(lambda: one(user, "slider objects[0].radius_m").value == 198)
        assert scene(session).objects[0].radius_m == 12.0


async def test_handles_move_what_they_belong_to(session: Session) -> None:
    async with visiting(session, simulator.build) as user:
        await until(lambda: layer(user, "scene"))
        user.find(kind=PlanView).trigger(
            "drag", {"id": "objects[0].position_ned", "north": 40.0, "east": 5.0, "done": True}
        )
        await until(lambda: scene(session).objects[0].position_ned == (40.0, 5.0, 21.6))
        assert one(user, "part").value == "objects[0]"
        await until(lambda: [each["at"] for each in layer(user, "handles") if each["id"] == "objects[0].position_ned"]
                    == [[40.0, 5.0]])  # fmt: skip


async def test_a_click_selects_and_sizes_can_be_dragged(session: Session) -> None:
    async with visiting(session, simulator.build) as user:
        await until(lambda: layer(user, "scene"))
        assert not [each for each in layer(user, "handles") if "radius_m" in each["id"]]
        user.find(kind=PlanView).trigger("pick", {"id": None, "north": 75.5, "east": 0.5})
        await until(lambda: [each for each in layer(user, "handles") if each["id"] == "objects[1].radius_m"])
        assert one(user, "part").value == "objects[1]"


async def test_objects_come_and_go(session: Session) -> None:
    async with visiting(session, simulator.build) as user:
        await until(lambda: layer(user, "scene"))
        user.find(marker="add plane").click()
        user.find(kind=PlanView).trigger("pick", {"id": None, "north": 40.04, "east": -7.38})
        await until(lambda: scene(session).objects[3].position_ned == (40.0, -7.4, 20.0))
        await until(lambda: [each for each in layer(user, "scene") if each.get("label") == "plane 1"])
        assert one(user, "part").value == "objects[3]"
        user.find(marker="remove object").click()
        await until(lambda: len(scene(session).objects) == 3)
        await until(lambda: one(user, "part").value == "vehicle")


async def test_a_straight_path_becomes_a_curve(session: Session) -> None:
    async with visiting(session, simulator.build) as user:
        await until(lambda: layer(user, "scene"))
        one(user, "ping").set_value(14)
        await until(lambda: one(user, "clock").text.startswith("ping 14 "))
        user.find(marker="add way-point").click()
        await until(lambda: len(scene(session).vehicle.waypoints) == 3)
        await user.should_see(marker="vehicle.waypoints[1].t_s")
        assert [each["id"] for each in layer(user, "handles") if each["id"].startswith("vehicle.waypoints[")] == [
            f"vehicle.waypoints[{place}].position_ned" for place in range(3)
        ]


async def test_each_effect_has_its_switch(session: Session) -> None:
    async with visiting(session, simulator.build) as user:
        user.find(marker="side Effects").click()
        for effect in EFFECTS:
            box = one(user, f"effect {effect.path}")
            assert box.value == is_on(scene(session), effect)
            if effect.path not in SWITCHED:
                continue
            box.set_value(not box.value)
            assert is_on(scene(session), effect) == box.value
        session.undo()
        await until(lambda: one(user, "effect sea_bed.rough").value == is_on(scene(session), EFFECTS[-1]))


async def test_a_scene_that_cannot_be_is_reported_over_the_image(session: Session) -> None:
    async with visiting(session, simulator.build) as user:
        await until(lambda: layer(user, "scene"))
        session.do(do.SetScene("sea_bed.depth_m", 2.0))
        (fan,) = user.find(kind=FanView).elements
        await until(lambda: "below the sea-bed" in fan._props.get("busy", ""))
        session.undo()
        await until(lambda: fan._props.get("busy") == "")


async def test_rehearsing_shows_scores_and_tracks(session: Session) -> None:
    async with visiting(session, simulator.build) as user:
        user.find(marker="side Run").click()
        user.find(marker="rehearse").click()
        await until(lambda: one(user, "rehearsed").text.startswith("27 pings"))
        (table,) = user.find(kind=ui.table).elements
        assert {row["object"] for row in table.rows} <= {"near", "far", "port"}
        assert layer(user, "rehearsed")


async def test_saving_shows_the_difference_first(session: Session, tmp_path: Path) -> None:
    async with visiting(session, simulator.build) as user:
        user.find(marker="save scene").click()
        name = one(user, "scene file")
        assert name.value == str(tmp_path / "figure11.toml")  # not the one that came with ODS
        (code,) = user.find(kind=ui.code).elements
        assert "+duration_s = 4.0" in code.content
        assert not (tmp_path / "figure11.toml").exists()
        name.set_value("/elsewhere/figure11.toml")
        await until(lambda: "not under the workbench's folders" in code.content)
        assert not one(user, "write scene").enabled
        name.set_value(str(tmp_path / "own.toml"))
        await until(lambda: one(user, "write scene").enabled)
        user.find(marker="write scene").click()
        await until(lambda: (tmp_path / "own.toml").exists())
        assert "duration_s = 4.0" in (tmp_path / "own.toml").read_text()
        assert session.state.data.path == str(tmp_path / "own.toml")
