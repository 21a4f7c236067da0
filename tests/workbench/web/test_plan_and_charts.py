"""What the plan and the charts give to the page's script, and what they make of its events."""

import asyncio
import json
from collections.abc import Callable
from pathlib import Path
from typing import get_args

import numpy as np
import pytest
from nicegui.element import Element
from nicegui.events import GenericEventArguments, handle_event

from ods.workbench.web.views import plan_view
from ods.workbench.web.views.chart_view import Axis, Band, ChartView, Colour, Curve, Even, Panel, Strip
from ods.workbench.web.views.plan_view import Circle, Drag, Ellipse, Handle, Line, Pick, PlanView
from tests.workbench.pages.visiting import numbers, simulated


def on_a_page(test: Callable[[], None]) -> None:
    """Do something where elements can be made."""

    async def run() -> None:
        done = []

        def root() -> None:
            test()
            done.append(True)

        async with simulated(root) as user:
            await user.open("/")
        assert done

    asyncio.run(run())


def emit(element: Element, event: str, reported: dict[str, object]) -> None:
    """Do as the page's script does."""
    for listener in element._event_listeners.values():
        if listener.type == event:
            handle_event(listener.handler, GenericEventArguments(sender=element, client=element.client, args=reported))


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


def test_events_are_reported_as_clicks_drags_and_places() -> None:
    reported: list[object] = []

    def test() -> None:
        plan, chart = PlanView(), ChartView()
        plan.on_pick(reported.append)
        plan.on_drag(reported.append)
        chart.on_pick(reported.append)
        chart.on_mark(reported.append)
        chart.on_drag(lambda *line: reported.append(line))
        emit(plan, "pick", {"id": None, "north": 1, "east": 2.5})
        emit(plan, "drag", {"id": "w0", "north": 3.0, "east": 4.0, "done": True})
        emit(chart, "pick", {"x": 12})
        emit(chart, "mark", {"id": "3"})
        emit(chart, "drag", {"name": "high", "value": 5})
        assert chart._props["picks"]

    on_a_page(test)
    assert reported == [Pick(None, (1.0, 2.5)), Drag("w0", (3.0, 4.0), True), 12.0, "3", ("high", 5.0)]


def test_panels_and_strips_are_what_the_script_can_read() -> None:
    def test() -> None:
        chart = ChartView()
        x, gap = np.array([0.0, 1.0]), np.array([2.0, np.nan])
        band = Band("uncertainty", "within", x, gap - 1.0, gap + 1.0)
        curves = [Curve("active", "tracked", x, gap), Curve("first", "level", Even(0.5, 0.25), np.arange(4))]
        chart.show(Axis("time, s", 0.0, 9.0), [Panel(Axis("x, m"), curves, [band])], columns=2)
        reported = json.loads(chart._props["shown"])
        assert (reported["x"]["low"], reported["x"]["high"], reported["columns"]) == (0.0, 9.0, 2)
        first, second = reported["panels"][0]["curves"]
        assert numbers(first["x"]) == [0.0, 1.0]
        assert numbers(first["y"]) == [2.0, pytest.approx(np.nan, nan_ok=True)]
        assert (second["x"], numbers(second["y"])) == ({"x0": 0.5, "dx": 0.25}, [0.0, 1.0, 2.0, 3.0])
        assert numbers(reported["panels"][0]["bands"][0]["high"])[0] == 3.0
        chart.show(Axis("time, s", 0.0, 9.0), [], [Strip("1", "object 1", [("active", 0.0, 9.0)])])
        reported = json.loads(chart._props["shown"])
        assert reported["panels"] == []
        assert reported["strips"] == [
            {"id": "1", "label": "object 1", "spans": [["active", 0.0, 9.0]], "marked": False}
        ]

    on_a_page(test)


def test_every_role_has_a_colour() -> None:
    script = (Path(plan_view.__file__).parent / "charts" / "index.js").read_text()
    roles = {role for part in get_args(Colour) for role in get_args(part)}
    assert {"veto", "first", "quiet"} <= roles
    assert {role for role in roles if f"\n  {role}: {{ colours:" not in script} == set()
