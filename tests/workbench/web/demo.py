"""A workbench with one page of two views: an image with one echo whose place is known. Run by tests and benchmarks."""

import numpy as np
from nicegui import ui

from ods.workbench.model.actions import SetView
from ods.workbench.session import Session
from ods.workbench.web import server
from ods.workbench.web.frames import Circle, Frame, FrameBoard, cells_of
from ods.workbench.web.views.fan_view import FanView, Spot

BEAMS, SAMPLES, DR_M = 60, 2000, 0.05
ECHO_BEAM, ECHO_SAMPLE = 40, 1200
BEARING = np.radians(np.linspace(-59.0, 59.0, BEAMS))


def frame(number: int = 0, caption: str = "") -> Frame:
    """Return noise at 0 dB with one sample at 30 dB, circled."""
    level = np.random.default_rng(number).normal(0.0, 2.0, (BEAMS, SAMPLES)).astype(np.float32)
    level[ECHO_BEAM, ECHO_SAMPLE] = 30.0
    attended = np.ones(level.shape, np.bool_)
    attended[:, :400] = False
    scale = (-10.0, 41.0)
    echo = Circle(ECHO_SAMPLE * DR_M, float(BEARING[ECHO_BEAM]), 2.0)
    text = caption or f"ping {number}"
    return Frame(cells_of(level, scale), BEARING, 0.0, DR_M, scale, (echo,), (("high", 14.0),), attended, text)


def build(session: Session) -> None:
    """Build two views of two boards' images, and labels that say what was pointed at."""
    board = FrameBoard()
    board.show("before", frame(1))
    board.show("after", frame(2))
    hovered, picked = ui.label("none").props("id=hovered"), ui.label("none").props("id=picked")

    def hover(spot: Spot) -> None:
        hovered.set_text(f"{spot.range_m:.2f} {spot.bearing_rad:.4f} {spot.level_db:.1f} {spot.beam} {spot.sample}")

    def pick(spot: Spot) -> None:
        picked.set_text(f"{spot.beam}")
        session.do(SetView("pinned_beam", spot.beam))

    with ui.row().classes("w-full no-wrap"):
        for view in ("before", "after"):
            fan = FanView(session, board, view, title=view).classes("w-1/2")
            fan.on_hover(hover)
            fan.on_pick(pick)
    ui.label(f"session {session.number}").props("id=session")
    for name, value in (("presentation", "polar"), ("attention", True), ("palette", "gray")):
        ui.button(name, on_click=lambda name=name, value=value: session.do(SetView(name, value))).props(f"id={name}")
    ui.button("next", on_click=lambda: board.show("before", frame(3))).props("id=next")


def main() -> None:
    """Serve it."""
    bound = server.listening(0)
    server.serve(server.Site(build, Session), bound, lambda link: print(link, flush=True))


if __name__ == "__main__":
    main()
