"""Tools over the plan of a scene: objects put down, copied and listed, way-points, the grid that they snap to."""

import math
from collections.abc import Callable

from nicegui import ui

from ods.workbench.engine.scene.view import Pictured
from ods.workbench.model import actions as do
from ods.workbench.model.scene.handles import Spot, place_at, snapped
from ods.workbench.pages.parts.folding import folds, tool_bar
from ods.workbench.pages.parts.tips import tip
from ods.workbench.pages.scene.panels import try_to
from ods.workbench.pages.scene.table import BESIDE_M, SceneTable
from ods.workbench.session import Session
from ods.workbench.web.views.plan_view import PlanView

PLAN = "plan, m: click selects, handles drag"
SNAPS = {0.0: "free", 0.1: "snap 0.1 m", 0.5: "snap 0.5 m", 1.0: "snap 1 m", 5.0: "snap 5 m"}
SHAPES: tuple[tuple[do.ShapeName, str], ...] = (
    ("sphere", "circle"), ("cylinder", "panorama_fish_eye"), ("plane", "crop_landscape"),
)  # fmt: skip
"""With their icons."""


class PlanTools:
    """One row, above the plan."""

    def __init__(
        self, session: Session, plan: PlanView, selected: Callable[[], str], select: Callable[[str], None]
    ) -> None:
        """selected: returns the part that is; select: selects another."""
        self._session, self._plan = session, plan
        self._selected, self._select = selected, select
        self.step_m = 0.1
        """That what is dragged or put down snaps to."""
        self.moment: Pictured | None = None
        """The ping that is shown."""
        self._adds: do.ShapeName | None = None
        """What the next click in the plan puts there."""
        self._middle: Spot | None = None
        """Of the plan, once it was moved."""
        plan.on_look(lambda place: setattr(self, "_middle", place))
        plan.set_title(PLAN)
        with tool_bar():
            for shape, icon in SHAPES:
                add = ui.button(shape, icon=icon, on_click=lambda shape=shape: self._choose(shape))
                add.props("flat dense no-caps").mark(f"add {shape}")
                add.tooltip("then click in the plan; again: in the middle of what the plan shows")
            with folds("more_horiz", "way-points, copy, table, snap", 560):
                self._build_others()

    def put(self, at: Spot) -> bool:
        """Put there what was chosen; return whether something was."""
        if self._adds is None:
            return False
        self._add(self._adds, at)
        return True

    def _build_others(self) -> None:
        def tool(icon: str, words: str, does: Callable[[], object], marker: str) -> None:
            button = ui.button(icon=icon, on_click=lambda: does()).props("flat dense no-caps")
            tip(button, words).mark(marker)

        table = SceneTable(self._session)
        tool("add_location", "a way-point of the selected path, where it is now", self._add_waypoint, "add way-point")
        tool("content_copy", "another like the selected object", self._copy, "copy object")
        tool("table_rows", "all objects as a table", table.open, "object table")
        snap = ui.select(SNAPS, value=self.step_m, on_change=lambda event: setattr(self, "step_m", event.value))
        snap.props("dense options-dense borderless").tooltip("what is dragged or put down").mark("snap")

    def _choose(self, shape: do.ShapeName) -> None:
        """Let the next click put an object there; chosen twice, it is put where the plan looks at."""
        if self._adds == shape:
            self._add(shape, self._middle or self._ahead())
        else:
            self._adds = shape
            self._plan.set_title(f"click where the {shape} is to be")

    def _ahead(self) -> Spot:
        """Return a place half-way into the fan."""
        if self.moment is None:
            return 0.0, 0.0
        north, east, heading = self.moment.plan.vehicle
        reach = 0.4 * self.moment.sonar.range_max_m
        return north + reach * math.cos(heading), east + reach * math.sin(heading)

    def _add(self, shape: do.ShapeName, at: Spot) -> None:
        """Put an object there, as deep as the sonar."""
        self._adds = None
        self._plan.set_title(PLAN)
        if self.moment is None or self._session.state.scene is None:
            return
        north, east = (snapped(value, self.step_m) for value in at)
        down = round(float(self.moment.head.position_ned[2]), 2)
        try_to(self._session, do.AddObject(shape, (north, east, down)))
        self._select_last()

    def _copy(self) -> None:
        if self._selected().startswith("objects["):
            at = int(self._selected()[len("objects[") : -1])
            try_to(self._session, do.CopyObject(at, (0.0, BESIDE_M, 0.0)))
            self._select_last()

    def _select_last(self) -> None:
        scene = self._session.state.scene
        if scene is not None:
            self._select(f"objects[{len(scene.objects) - 1}]")

    def _add_waypoint(self) -> None:
        state, of = self._session.state, self._selected()
        if state.scene is None or self.moment is None or of == "sea_bed":
            return
        t_s = round(self.moment.t_s, 2)
        try_to(self._session, do.AddWaypoint(of, t_s, place_at(state.scene, of, t_s)))
