"""An echogram in the browser: levels of range against ping, with what was found and what was amiss over them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import msgspec
import numpy as np
from nicegui.element import Element

from ods.workbench.engine.echogram.layers import Layers
from ods.workbench.engine.echogram.levels import Echogram
from ods.workbench.model.state import EchogramLayer, State, View
from ods.workbench.session import Session
from ods.workbench.web.follow import follow
from ods.workbench.web.frames import Cells, Channel, FrameSource, cells_of, new_version

SCALE_DB = (-20.0, 60.0)
"""Over the median, of the bytes that are sent: the colour scale may be any part of it."""


@dataclass(frozen=True, eq=False)
class EchogramPicture:
    """An echogram as its view shows it."""

    cells: Cells
    """(columns, cells): 0 stands for no sample, 1 to 255 for SCALE_DB."""
    pings: int
    per_column: int
    cell_m: float
    t_s: list[float | None]
    caption: str = ""
    attended: None = None
    version: int = field(default_factory=new_version)

    def header(self) -> dict[str, Any]:
        """Return what the view gets besides the cells."""
        return {
            "pings": self.pings,
            "per_column": self.per_column,
            "cell_m": self.cell_m,
            "t_s": self.t_s,
            "scale_db": SCALE_DB,
            "caption": self.caption,
        }


def picture_of(echogram: Echogram, caption: str = "") -> EchogramPicture:
    """Return what is sent of an echogram."""
    cells = cells_of(echogram.level_db, SCALE_DB)
    cells = np.where(np.isfinite(echogram.level_db), np.maximum(cells, 1), np.uint8(0))
    t_s = [round(t, 3) if t == t else None for t in echogram.t_s.tolist()]
    return EchogramPicture(cells, echogram.pings, echogram.per_column, echogram.cell_m, t_s, caption)


class EchogramView(Element, component="echogram_view.js", esm={"ods-charts": "charts"}):
    """Click: that ping; wheel: zoom; drag: pan; double click: all of it again. `height` as in CSS.

    Palette, colour scale, the layers shown and the ping are the session's.
    """

    def __init__(self, session: Session, source: FrameSource, view: str, *, height: str = "60vh") -> None:
        super().__init__()
        self._channel = Channel(source, view)
        self._props.update({"channel": self._channel.key, "title": "", "busy": "", "layers": "{}", "marked": None})
        self._props.update({"cursor": session.state.ping, **_shown(session.state.view)})
        self.style(f"height: {height}; width: 100%")
        follow(session, self, self._follow)

    def show_layers(self, layers: Layers) -> None:
        """Show these over the levels, as far as they are switched on."""
        self._set("layers", msgspec.json.encode(layers).decode())  # as text: NiceGUI would watch each number

    def set_title(self, title: str) -> None:
        """Write something over it."""
        self._set("title", title)

    def set_busy(self, why: str) -> None:
        """Say what is still to come; empty: it is the newest."""
        self._set("busy", why)

    def on_pick(self, callback: Callable[[int], None]) -> None:
        """Call `callback` with the place of the ping that is clicked at."""
        self.on("pick", lambda event: callback(int(event.args["place"])))

    def _follow(self, before: State, after: State) -> None:
        if before.ping != after.ping:
            self._set("cursor", after.ping)
        for name, value in _shown(after.view).items():
            self._set(name, value)

    def _set(self, name: str, value: object) -> None:
        """Send the script one property; NiceGUI would send all of them."""
        if self._props.get(name) != value:
            with self._props.suspend_updates():
                self._props[name] = value
            self.run_method("set", name, value)


def _shown(view: View) -> dict[str, str | list[float] | Sequence[EchogramLayer] | int | None]:
    return {
        "palette": view.palette,
        "limits": [view.lowest_db, view.highest_db],
        "shown": list(view.echogram_layers),
        "marked": view.marked_obstacle,
    }
