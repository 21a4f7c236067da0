"""Tables of objects, as observer and live show them."""

import math
from collections.abc import Callable, Sequence

from nicegui import ui

from ods.messages import Obstacle, Vector3
from ods.workbench.engine.mission.tracked import track_name

Columns = Sequence[tuple[str, str]]
"""Name and heading of each."""
NUMBERS: Columns = (
    ("name", "track"), ("state", "state"), ("north", "north, m"), ("east", "east, m"), ("speed", "speed, m/s"),
    ("radius", "radius, m"), ("nearest", "nearest, m, in s"), ("exists", "exists"), ("seen", "seen"),
)  # fmt: skip


def table(title: str, columns: Columns, clicked: Callable[[str], None] | None) -> ui.table:
    """Build a table; clicked: gets the id of the row."""
    fields = [
        {"name": name, "label": label, "field": name, "align": "right" if at else "left"}
        for at, (name, label) in enumerate(columns)
    ]
    built = ui.table(rows=[], columns=fields, title=title, row_key=columns[0][0])
    built.props("dense flat bordered hide-pagination :rows-per-page-options=[0] title-class=text-sm")
    built.add_slot("no-data", '<span class="opacity-70">none</span>')  # Quasar's own has a sign of warning
    built.classes("grow min-w-0").style("max-height: 190px")
    if clicked is not None:
        callback = clicked
        built.on("rowClick", lambda event: callback(str(event.args[1]["id"])))
    return built


def numbers(item: Obstacle, name: str = "") -> dict[str, object]:
    """Return the row of one object, for NUMBERS; name: what its track is called, by default by its id."""
    cpa = item.cpa
    return {
        "id": item.id,
        "name": name or track_name(item.id),
        "state": item.state.replace("_", "-") + (", ignored" if item.ignored_by >= 0 else ""),
        **place(item.position_ned, item.sigma_position),
        "speed": f"{math.hypot(*item.velocity_ned[:2]):.2f}",
        "radius": f"{item.radius_m:.1f} ± {item.sigma_radius:.1f}",
        "nearest": "" if cpa is None else f"{cpa.distance_m:.1f} ± {cpa.sigma_m:.1f}, {cpa.time_s:.0f}",
        "exists": f"{item.existence:.2f}",
        "seen": item.times_seen,
    }


def place(position: Vector3, sigma: Vector3) -> dict[str, object]:
    """Return north and east with their standard deviations."""
    axes = zip(("north", "east"), position, sigma, strict=False)
    return {name: f"{at:.1f} ± {error:.1f}" for name, at, error in axes}
