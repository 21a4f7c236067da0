"""Beside the plan and the image: what the parts of the scene are like, effects, curves, cost and rehearsal."""

from collections.abc import Callable

from nicegui import ui

from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.sonar.model import SonarModel
from ods.workbench.engine.scene.curves import beam_pattern, reflection, vertical_pattern
from ods.workbench.engine.scene.rehearsal import Rehearsal
from ods.workbench.model.actions import RemoveObject, SetScene
from ods.workbench.model.scene.dials import image_groups, object_groups, sea_bed_groups, vehicle_groups
from ods.workbench.model.state import State
from ods.workbench.pages.parts.tips import tip
from ods.workbench.pages.scene import panels
from ods.workbench.pages.scene.charts import overlaid
from ods.workbench.pages.scene.work import build_cost, build_rehearsal
from ods.workbench.session import Session
from ods.workbench.web.follow import follow
from ods.workbench.web.views.chart_view import Axis, ChartView

VEHICLE, SEA_BED = "vehicle", "sea_bed"
FAINTEST_DB = -60.0
"""Lower end of the patterns."""


class Side:
    """The column beside."""

    def __init__(
        self, session: Session, selected: Callable[[str], None], rehearsed: Callable[[Rehearsal | None], None]
    ) -> None:
        """selected: gets the part that is chosen; rehearsed: what came of a rehearsal."""
        self._session, self._selected = session, selected
        self._part = VEHICLE
        with ui.tabs().props("dense no-caps inline-label align=justify").classes("w-full") as tabs:
            names = [ui.tab(name).mark(f"side {name}") for name in ("Parts", "Effects", "Curves", "Run")]
        with ui.tab_panels(tabs, value=names[0], animated=False).classes("w-full bg-transparent"):
            with ui.tab_panel(names[0]).classes("p-1 gap-1"):
                self._build_parts()
            with ui.tab_panel(names[1]).classes("p-1 gap-1"):
                self._build_effects()
            with ui.tab_panel(names[2]).classes("p-1 gap-1"):
                self._build_curves()
            with ui.tab_panel(names[3]).classes("p-1 gap-2"):
                build_rehearsal(session, rehearsed)
                ui.separator()
                build_cost(session)
        follow(session, self._list, self._follow)
        self.show(VEHICLE)

    def show(self, part: str) -> None:
        """Show the sliders of a part."""
        self._part = part
        self._list.set_options(_parts(self._session.state.scene), value=part)
        self._panel.clear()
        with self._panel:
            self._fill()
        self._show_surface()

    def show_sonar(self, sonar: SonarModel) -> None:
        """Show the patterns of the sonar."""
        planes = vertical_pattern(sonar)
        names = ["S(beta)"] if len(planes) == 1 else [f"plane {number}" for number in range(1, len(planes) + 1)]
        curves = list(zip(names, planes, strict=True))
        overlaid(self._vertical, curves, Axis("elevation beta, °"), Axis("S, dB one way", FAINTEST_DB))
        beam = [("a beam", beam_pattern(sonar))]
        overlaid(self._beam, beam, Axis("off the beam's axis, °"), Axis("dB", FAINTEST_DB))

    def _build_parts(self) -> None:
        with ui.row().classes("items-center w-full no-wrap"):
            self._list = ui.select({}, label="part").props("dense options-dense").classes("grow").mark("part")
            self._list.on_value_change(
                lambda event: event.value not in (None, self._part) and self._selected(event.value)
            )
            remove = ui.button(icon="delete", on_click=self._remove).props("flat round dense").mark("remove object")
            tip(remove, "take this object out")
        self._panel = ui.column().classes("w-full gap-0")

    def _build_effects(self) -> None:
        panels.effects(self._session)
        with ui.row().classes("items-center gap-2"):
            seed = ui.number("seed", value=_seed(self._session), min=0, step=1, precision=0).props("dense").mark("seed")
            seed.on_value_change(lambda event: self._set_seed(event.value))
            ui.label("the same seed gives the same bytes").classes("text-xs opacity-70")
        seed.on("blur", lambda: seed.set_value(_seed(self._session)))  # emptied, or no number
        follow(self._session, seed, lambda _, __: seed.set_value(_seed(self._session)))
        panels.groups(self._session, image_groups())

    def _build_curves(self) -> None:
        ui.label("vertical sensitivity, figure 8").classes("text-xs opacity-70")
        self._vertical = ChartView(height="13rem")
        ui.label("horizontal beam pattern").classes("text-xs opacity-70")
        self._beam = ChartView(height="13rem")
        ui.label("reflection of the selected surface, equation 3").classes("text-xs opacity-70")
        self._surface = ChartView(height="13rem")

    def _fill(self) -> None:
        scene, session = self._session.state.scene, self._session
        if scene is None:
            return
        if self._part == SEA_BED:
            panels.groups(session, sea_bed_groups(scene))
            return
        if self._part == VEHICLE:
            panels.groups(session, vehicle_groups(scene))
        else:
            place = int(self._part[len("objects[") : -1])
            name = (
                ui.input("name", value=scene.objects[place].name).props("dense").classes("w-full").mark("object name")
            )
            name.on("blur", lambda: panels.try_to(session, SetScene(f"{self._part}.name", name.value)))
            panels.groups(session, object_groups(scene, place))
        panels.waypoints(session, self._part)

    def _show_surface(self) -> None:
        scene = self._session.state.scene
        bed = scene.sea_bed if scene else None
        surface = bed.surface if bed else None
        if scene is not None and self._part.startswith("objects["):
            surface = scene.objects[int(self._part[len("objects[") : -1])].surface
        curves = [("gamma(alpha)", reflection(surface))] if surface else []
        overlaid(self._surface, curves, Axis("incidence alpha, °"), Axis("gamma", 0.0))

    def _follow(self, before: State, after: State) -> None:
        if _structure(before.scene) != _structure(after.scene):
            parts = _parts(self._session.state.scene)
            self.show(self._part if self._part in parts else VEHICLE)
        elif before.scene != after.scene:
            self._show_surface()

    def _set_seed(self, value: float | None) -> None:
        scene = self._session.state.scene
        if scene is not None and value is not None and int(value) != scene.seed:
            panels.try_to(self._session, SetScene("seed", int(value)))

    def _remove(self) -> None:
        if self._part.startswith("objects["):
            panels.try_to(self._session, RemoveObject(int(self._part[len("objects[") : -1])))


def _seed(session: Session) -> int:
    return session.state.scene.seed if session.state.scene is not None else 0


def _parts(scene: SceneFile | None) -> dict[str, str]:
    """Return what sliders there are for, under the names that are shown."""
    if scene is None:
        return {}
    objects = {f"objects[{place}]": item.name for place, item in enumerate(scene.objects)}
    bed = {SEA_BED: "sea-bed"} if scene.sea_bed is not None else {}
    return {VEHICLE: "vehicle", **bed, **objects}


def _structure(scene: SceneFile | None) -> object:
    """Return what decides which sliders there are; their values do not."""
    if scene is None:
        return None
    bed = scene.sea_bed
    moving = [scene.vehicle, *scene.objects]
    points = [[(point.t_s, point.position_ned[2]) for point in each.waypoints] for each in moving]
    return _parts(scene), [type(each) for each in moving], points, bed is None, bed is not None and bed.rough is None
