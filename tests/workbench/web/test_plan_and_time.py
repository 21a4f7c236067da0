"""What the plan and the time view tell the page's script, and what they make of its events."""

import asyncio
import json
from collections.abc import Callable
from pathlib import Path
from typing import get_args

from nicegui.element import Element
from nicegui.events import GenericEventArguments, handle_event
from nicegui.testing.user_simulation import user_simulation

from ods.workbench.web import plan_view
from ods.workbench.web.plan_view import Circle, Drag, Ellipse, Handle, Line, Pick, PlanView
from ods.workbench.web.time_view import Band, Curve, Panel, Strip, TimeView


def on_a_page(test: Callable[[], None]) -> None:
    """Do something where elements can be made."""

    async def run() -> None:
        done = []

        def root() -> None:
            test()
            done.append(True)

        async with user_simulation(root) as user:
            await user.open("/")
        assert done

    asyncio.run(run())


def emit(element: Element, event: str, told: dict[str, object]) -> None:
    """Do as the page's script does."""
    for listener in element._event_listeners.values():
        if listener.type == event:
            handle_event(listener.handler, GenericEventArguments(sender=element, client=element.client, args=told))


def test_layers_are_what_the_script_can_read() -> None:
    def test() -> None:
        plan = PlanView(title="plan")
        plan.show("ways", [Line([(0.0, 1.0), (2.0, 3.0)], "truth", "rock")])
        plan.show("now", [Circle((5.0, 6.0), 1.5, "active", id="7"), Ellipse((5.0, 6.0), (2.0, 1.0), 0.5)])
        plan.show("now", [Handle("a", (9.0, 9.0), "path")])
        layers = {name: json.loads(text) for name, text in plan._props["layers"].items()}
        assert list(layers) == ["ways", "now"]
        assert layers["now"] == [
            {"kind": "handle", "id": "a", "at": [9.0, 9.0], "role": "path", "label": "", "marked": False}
        ]
        assert layers["ways"][0]["points"] == [[0.0, 1.0], [2.0, 3.0]]

    on_a_page(test)


def test_events_are_told_as_clicks_drags_and_times() -> None:
    told: list[object] = []

    def test() -> None:
        plan, times = PlanView(), TimeView()
        plan.on_pick(told.append)
        plan.on_drag(told.append)
        times.on_time(told.append)
        times.on_mark(told.append)
        emit(plan, "pick", {"id": None, "north": 1, "east": 2.5})
        emit(plan, "drag", {"id": "w0", "north": 3.0, "east": 4.0, "done": True})
        emit(times, "pick", {"t_s": 12})
        emit(times, "mark", {"id": "3"})

    on_a_page(test)
    assert told == [Pick(None, (1.0, 2.5)), Drag("w0", (3.0, 4.0), True), 12.0, "3"]


def test_panels_and_strips_are_what_the_script_can_read() -> None:
    def test() -> None:
        times = TimeView()
        curve = Curve("active", "tracked", [0.0, 1.0], [2.0, None])
        times.show((0.0, 9.0), [Panel("x, m", [curve], [Band("uncertainty", [0.0, 1.0], [1.0, None], [3.0, None])])])
        times.show((0.0, 9.0), [], [Strip("1", "object 1", [("active", 0.0, 9.0)])])
        told = json.loads(times._props["shown"])
        assert told["span"] == [0.0, 9.0]
        assert told["panels"] == []
        assert told["strips"] == [{"id": "1", "label": "object 1", "spans": [["active", 0.0, 9.0]], "marked": False}]

    on_a_page(test)


def test_every_role_has_a_colour() -> None:
    script = (Path(plan_view.__file__).parent / "charts" / "index.js").read_text()
    roles = set(get_args(plan_view.Role))
    assert {role for role in roles if f"\n  {role}: {{ colours:" not in script} == set()
