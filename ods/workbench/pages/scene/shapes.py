"""A scene, and what came of its rehearsal, as shapes of the plan."""

from collections.abc import Sequence

from ods.base.arrays import Floats
from ods.workbench.engine.scene.plan import Plan
from ods.workbench.engine.scene.rehearsal import Rehearsal
from ods.workbench.model.scene.handles import Handle
from ods.workbench.web.views import plan_view as shapes
from ods.workbench.web.views.plan_view import Shape


def plan_shapes(plan: Plan, selected: str) -> list[Shape]:
    """Return sector, paths, outlines and vehicle."""
    drawn: list[Shape] = [shapes.Area(_places(plan.sector), "sector")]
    for of, way in plan.paths.items():
        role: shapes.Role = "vehicle" if of == "vehicle" else "path"
        drawn.append(shapes.Line(_places(way), role, dashed=of != "vehicle", marked=of == selected))
    for place, outline in enumerate(plan.outlines):
        marked = f"objects[{place}]" == selected
        drawn.append(shapes.Area(_places(outline.edge), "object", outline.name, marked=marked))
    north, east, heading = plan.vehicle
    drawn.append(shapes.Mark((north, east), "vehicle", heading))
    return drawn


def handle_shapes(handles: Sequence[Handle], selected: str) -> list[Shape]:
    """Return what can be dragged: every place, and of what is selected its sizes, turns and way-points too."""
    return [
        shapes.Handle(handle.path, handle.at, "vehicle" if handle.path.startswith("vehicle") else "object", marked=mine)
        for handle in handles
        if (mine := handle.path.partition(".")[0] == selected) or handle.kind == "place"
    ]


def rehearsed_shapes(result: Rehearsal | None) -> list[Shape]:
    """Return where each track went, and the circle it ended with."""
    drawn: list[Shape] = []
    for course in result.courses() if result else []:
        drawn.append(shapes.Line(course.places, course.state))
        drawn.append(shapes.Circle(course.places[-1], course.radius_m, course.state, str(course.id)))
    return drawn


def _places(points: Floats) -> list[tuple[float, float]]:
    return [(round(north, 3), round(east, 3)) for north, east in points.tolist()]
