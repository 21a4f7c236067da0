"""Pictures of the image processing menu: frames of an answer, their titles, and what is read in them."""

import math
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from msgspec.structs import replace

from ods.messages import Detection
from ods.workbench.engine.ping.analysis import PingAnalysis
from ods.workbench.engine.ping.labels import of_ping
from ods.workbench.engine.ping.look import Look
from ods.workbench.engine.ping.thresholds import thresholds
from ods.workbench.engine.ping.truth import Judged, TrueCircle
from ods.workbench.model.state import State, Tuning
from ods.workbench.pages.ping.work import Answer, last_stage
from ods.workbench.web.frames import Circle, Frame, Kind, cells_of
from ods.workbench.web.views.fan_view import Spot

MAIN, BESIDE, OTHER = "main", "beside", "other"
"""Names of the views: of A, beside it, and of B where B blinks in A's place."""


def frames_of(answer: Answer) -> dict[str, Frame]:
    """Return the frames by the names of their views."""
    state = answer.state
    view = state.view
    drawn = partial(_frame, answer.a, judged=answer.judged_a)
    shown = {MAIN: drawn(state.tuning, view.shown_stage, state, _circles(answer))}
    if answer.b is not None and state.other is not None:
        own = _own_circles(answer.b, answer.judged_b, answer.true)
        shown[OTHER] = _frame(answer.b, state.other, view.shown_stage, state, own, judged=answer.judged_b)
    if answer.beside is not None:
        own = _own_circles(answer.beside, None, None)
        other = replace(state, labels=())
        shown[BESIDE] = _frame(answer.beside, state.tuning, view.shown_stage, other, own, judged=None)
    elif compares(state) and OTHER in shown:
        shown[BESIDE] = shown[OTHER]
    elif view.compared_stage is not None:
        shown[BESIDE] = drawn(state.tuning, view.compared_stage, state, shown[MAIN].circles)
    return shown


def compares(state: State) -> bool:
    """Return whether B is shown beside A."""
    return state.beside is None and state.other is not None and state.view.comparison == "split"


def title_of(tuning: Tuning, place: int) -> str:
    """Return what the image after a place of the chain is called."""
    chain = tuning.config.pipeline.chain()
    if not 0 <= place < len(chain):
        return "as recorded"
    return f"after {place + 1} {chain[place]['use']}" + (" (bypassed)" if place in tuning.bypassed else "")


def titles_of(answer: Answer) -> tuple[str, str]:
    """Return the titles of the picture and of that beside it."""
    state, view = answer.state, answer.state.view
    own = title_of(state.tuning, view.shown_stage)
    compared = title_of(state.tuning, -1 if view.compared_stage is None else view.compared_stage)
    if state.beside is not None:
        return f"{'' if state.other is None else 'A '}{own}", f"{Path(state.beside.data.path).name}: {own}"
    if state.other is None:
        return own, compared
    parted = answer.parted if view.comparison == "difference" else None
    counts = f": {len(parted.both)} both, {len(parted.only_a)} only A, {len(parted.only_b)} only B" if parted else ""
    return f"A {own}{counts}", f"B {title_of(state.other, view.shown_stage)}" if compares(state) else compared


def reading(answer: Answer | None, spot: Spot) -> str:
    """Return what is read at a place of the picture: range, bearing, and the level after each stage."""
    text = f"{spot.range_m:.2f} m, {math.degrees(spot.bearing_rad):+.1f}°, beam {spot.beam}"
    if answer is None:
        return text
    rows, columns = answer.a.looks[0].codes.shape
    if not (0 <= spot.beam < rows and 0 <= spot.sample < columns):
        return text
    levels = [f"{look.label} {look.reading_db(spot.beam, spot.sample):.1f}" for look in answer.a.looks]
    return f"{text}: dB over the median, {', '.join(levels)}"


def _frame(
    analysis: PingAnalysis,
    tuning: Tuning,
    place: int,
    state: State,
    circles: Sequence[Circle],
    *,
    judged: Judged | None,
) -> Frame:
    place = min(place, len(tuning.config.pipeline.chain()) - 1)
    look = analysis.after(place, tuning.bypassed)
    scale = state.view.lowest_db, state.view.highest_db
    attended = analysis.attended
    return Frame(
        cells=look.through(partial(cells_of, scale_db=scale)),
        bearing_rad=analysis.grid.bearing_rad,
        range0_m=analysis.grid.range0_m,
        dr_m=analysis.grid.dr_m,
        scale_db=scale,
        circles=tuple(circles),
        thresholds_db=_levels(look, tuning),
        attended=None if attended.all() else attended,
        labels=tuple(
            (*each.beams, *each.samples, each.shape, each.text)
            for _, each in of_ping(state.labels, analysis.place, analysis.ping)
        ),
        caption=f"ping {analysis.place}, {_count(len(analysis.detections.detections))}{_against_truth(judged)}",
    )


def _levels(look: Look, tuning: Tuning) -> tuple[tuple[str, float], ...]:
    return tuple((each.name, each.level_db) for each in thresholds(look, last_stage(tuning)[1]))


def _count(number: int) -> str:
    return f"{number} detection{'' if number == 1 else 's'}"


def counts_of(judged: Judged) -> str:
    """Return how many detections are right, false, or of an object that is found, and how many objects are missed."""
    more = f", {len(judged.more)} more of them" if judged.more else ""
    return f"{len(judged.right)} right{more}, {len(judged.false)} false, {len(judged.missed)} missed"


def _against_truth(judged: Judged | None) -> str:
    return "" if judged is None else f": {counts_of(judged)}"


def _own_circles(analysis: PingAnalysis, judged: Judged | None, true: Sequence[TrueCircle] | None) -> list[Circle]:
    """Return a chain's circles; where the truth is known, distinguished by it."""
    found = analysis.detections.detections
    if judged is None or true is None:
        return _with_kind(found, "detection")
    missed = [true[place] for place in judged.missed]
    return [
        *_with_kind([found[place] for place, _ in judged.right], "right"),
        *_with_kind([found[place] for place in judged.more], "detection"),
        *_with_kind([found[place] for place in judged.false], "false"),
        *[Circle(each.range_m, each.bearing_rad, each.radius_m, "missed") for each in missed],
    ]


def _circles(answer: Answer) -> list[Circle]:
    """Return A's circles; with the difference shown, those of B too."""
    found = answer.a.detections.detections
    if answer.parted is None or answer.b is None or answer.state.view.comparison != "difference":
        return _own_circles(answer.a, answer.judged_a, answer.true)
    other = answer.b.detections.detections
    return [
        *_with_kind([found[one] for one, _ in answer.parted.both], "detection"),
        *_with_kind([found[one] for one in answer.parted.only_a], "only_a"),
        *_with_kind([other[one] for one in answer.parted.only_b], "only_b"),
    ]


def _with_kind(found: Sequence[Detection], kind: Kind) -> list[Circle]:
    return [Circle(one.range_m, one.bearing_rad, one.radius_m, kind) for one in found]
