"""The stages of the chain with their sliders: added, removed, moved and bypassed."""

from collections.abc import Callable, Sequence
from functools import partial

import msgspec
from nicegui import ui

from ods.base.errors import OdsError
from ods.pipeline.settings import AttentionSettings, PipelineSettings, StageTable
from ods.pipeline.stage.configured import find_stage, stage_names
from ods.pipeline.stage.params import STAGES
from ods.workbench.model import actions as do
from ods.workbench.model.chain.edits import Entry, edited
from ods.workbench.model.chain.numbers import columns, follows, numbered, written
from ods.workbench.model.chain.numbers_first import with_numbers_first
from ods.workbench.model.paths import PathError
from ods.workbench.model.sliders import controls_of
from ods.workbench.model.state import State
from ods.workbench.pages.parts.control_row import ControlRow
from ods.workbench.pages.parts.tips import tip
from ods.workbench.pages.ping.add_stage import add_menu
from ods.workbench.session import Session
from ods.workbench.web.follow import PICTURE_FIRST_S, follow, in_loop

DETECTS = "detect."
FOLLOWING = "window, filter length, cut-off and fewest cells"
OF_THE_IMAGE = ("smallest_object_m", "min_range_m", "beam_width_deg", "vertical_half_deg")
"""Settings of the pipeline that belong to no stage."""


class StageList:
    """The list of stages and what concerns all of them. Complaints about a value are shown above it, as one line."""

    def __init__(self, session: Session) -> None:
        self._session = session
        chain = session.state.tuning.config.pipeline.chain()
        self._open = {f"{len(chain) - 1} {chain[-1]['use']}"}
        """Stages that are unfolded, by place and name."""
        self._dragged: int | None = None
        self._rows: list[tuple[str, ControlRow]] = []
        self._dr_m: float | None = None
        """Spacing of the range samples of the ping that is shown, from which numbers follow."""
        self._counted = ""
        with ui.row().classes("w-full items-center no-wrap"):
            ui.label("Chain").classes("text-base font-medium")
            ui.space()
            add_menu(known_stages(session.state.tuning.config.pipeline), self._add)
        self._complaint = ui.label().classes("text-negative text-sm w-full sticky top-0 z-10 backdrop-blur-md")
        self._complaint.mark("complaint")
        self._columns = ui.label().classes("text-xs opacity-70 w-full").mark("columns")
        self._list = ui.column().classes("w-full gap-0")
        self._build(session.state)
        follow(session, self._list, self._follow)

    def show_spacing(self, dr_m: float) -> None:
        """Take how far apart the range samples are of the ping that is shown."""
        if dr_m != self._dr_m:
            self._dr_m = dr_m
            self._show(self._session.state)

    def show_counts(self, counts: str) -> None:
        """Say below the detector's sliders what it found of what is there; empty: not known."""
        self._counted = counts
        self._counts.set_text(counts)

    def _do(self, action: do.Action) -> None:
        """Do something, or say why it cannot be done and show what is."""
        try:
            for each in self._with_numbers(action):
                self._session.do(each)
        except PathError as error:
            self._complaint.set_text(str(error))
            self._show(self._session.state)
        else:
            self._complaint.set_text("")

    def _with_numbers(self, action: do.Action) -> tuple[do.Action, ...]:
        if self._dr_m is None:
            return (action,)
        return with_numbers_first(self._session.state, action, self._dr_m)

    def _add(self, name: str) -> None:
        """Put a stage before the one that detects; one that detects takes that one's place."""
        tuning = self._session.state.tuning
        last = len(tuning.config.pipeline.chain()) - 1
        self._open.add(f"{last} {name}")
        if not name.startswith(DETECTS):
            self._do(do.AddStage(name, last))
            return

        def change(entries: list[Entry]) -> None:
            entries[-1] = ({"use": name}, False)

        try:
            if self._dr_m is not None:
                tuning = written(tuning, self._dr_m)
            self._do(do.SetTuning(edited(tuning, change), f"detect by {name}"))
        except PathError as error:
            self._complaint.set_text(str(error))

    def _follow(self, before: State, after: State) -> None:
        if _shape(before) != _shape(after):
            self._build(after)
        elif before.tuning is not after.tuning:
            in_loop(self._list, self._show_newest, PICTURE_FIRST_S)

    def _show_newest(self) -> None:
        if _shape(self._session.state) == self._shape:  # otherwise the list is about to be built again
            self._show(self._session.state)

    def _show(self, state: State) -> None:
        chain = self._chain(state)
        image = msgspec.to_builtins(state.tuning.config.pipeline, enc_hook=str)
        for path, row in self._rows:
            place, _, name = path.partition(".")
            table = {"attention": image["attention"], "image": image}.get(place) or chain[int(place)]
            row.show(table.get(name, row.default))
        self._columns.set_text(self._columns_text(state))

    def _chain(self, state: State) -> Sequence[StageTable]:
        """Return the stages with the numbers that they run by."""
        tuning = state.tuning
        return tuning.config.pipeline.chain() if self._dr_m is None else numbered(tuning, self._dr_m)

    def _columns_text(self, state: State) -> str:
        if self._dr_m is None or not follows(state.tuning):
            return ""
        count = columns(state.tuning, self._dr_m).subsample
        return f"columns of {count} sample{'s' * (count > 1)}; {FOLLOWING} follow from the smallest object"

    def _build(self, state: State) -> None:
        self._list.clear()
        self._rows, self._shape = [], _shape(state)
        chain = state.tuning.config.pipeline.chain()
        with self._list:
            for place, stage in enumerate(chain):
                self._stage(state, place, str(stage["use"]), place == len(chain) - 1)
            self._counts = ui.label(self._counted).classes("text-sm px-4 w-full").mark("counts")
            self._counts.classes("sticky bottom-0 z-10 backdrop-blur-md")
            self._fold("image", "image", "opacity-90", self._image)
            self._fold("attention", "focus of attention", "opacity-90", self._attention)
        self._columns.set_text(self._columns_text(state))

    def _fold(self, key: str, title: str, classes: str, build: Callable[[], None]) -> ui.expansion:
        """Build a group that is filled when it is unfolded first: the browser goes through all that is there at each
        move of a slider."""
        built: list[ui.column] = []

        def folded(open_now: bool) -> None:
            (self._open.add if open_now else self._open.discard)(key)
            if open_now and not built:
                with fold, ui.column().classes("w-full gap-0") as rows:
                    built.append(rows)
                    build()

        fold = ui.expansion(value=key in self._open, on_value_change=lambda event: folded(event.value))
        fold.props("dense dense-toggle expand-separator").classes(f"w-full {classes}").mark(f"fold {title}")
        with fold.add_slot("header"):
            ui.label(title).classes("self-center text-sm grow")
        folded(key in self._open)
        return fold

    def _image(self) -> None:
        values = msgspec.to_builtins(self._session.state.tuning.config.pipeline, enc_hook=str)
        for control in controls_of(PipelineSettings):
            if control.path in OF_THE_IMAGE:
                row = ControlRow(control, values[control.path], partial(self._set, f"pipeline.{control.path}"))
                self._rows.append((f"image.{control.path}", row))

    def _attention(self) -> None:
        values = msgspec.to_builtins(self._session.state.tuning.config.pipeline.attention)
        for control in controls_of(AttentionSettings):
            changed = partial(self._set, f"pipeline.attention.{control.path}")
            row = ControlRow(control, values[control.path], changed)
            self._rows.append((f"attention.{control.path}", row))

    def _stage(self, state: State, place: int, use: str, last: bool) -> None:
        bypassed = place in state.tuning.bypassed
        classes = "line-through opacity-60" if bypassed else ""
        fold = self._fold(f"{place} {use}", f"{place + 1}  {use}", classes, partial(self._settings_of, place, use))
        fold.props("draggable=true").on("dragstart", partial(self._drag, place))
        fold.on("dragover", js_handler="(event) => event.preventDefault()").on("drop", partial(self._drop, place))
        with fold.default_slot.parent.slots["header"]:
            self._buttons(place, last, bypassed)

    def _settings_of(self, place: int, use: str) -> None:
        table = self._chain(self._session.state)[place]
        try:
            controls = controls_of(find_stage(use).params)
        except OdsError as error:
            ui.label(str(error)).classes("text-negative text-sm")
            return
        for control in controls:
            changed = partial(self._set, f"pipeline.stage[{place}].{control.path}")
            row = ControlRow(control, table.get(control.path, control.default), changed)
            self._rows.append((f"{place}.{control.path}", row))

    def _buttons(self, place: int, last: bool, bypassed: bool) -> None:
        if not last:
            box = tip(ui.checkbox(value=not bypassed).props("dense size=xs"), "runs; off: bypassed")
            box.on("click.stop", lambda: None).mark(f"runs {place}")
            box.on_value_change(lambda event: self._do(do.BypassStage(place, on=not event.value)))
        _small(
            "arrow_upward", "earlier", place > 0 and not last, lambda: self._do(do.MoveStage(place, place - 1)), place
        )
        count = len(self._session.state.tuning.config.pipeline.chain())
        down = place + 2 < count
        _small("arrow_downward", "later", down, lambda: self._do(do.MoveStage(place, place + 1)), place)
        _small("close", "remove", not last, lambda: self._do(do.RemoveStage(place)), place)

    def _set(self, path: str, value: object) -> None:
        self._do(do.SetSetting(path, value))

    def _drag(self, place: int) -> None:
        self._dragged = place

    def _drop(self, place: int) -> None:
        last = len(self._session.state.tuning.config.pipeline.chain()) - 1
        if self._dragged is not None and self._dragged != place and last not in (place, self._dragged):
            self._do(do.MoveStage(self._dragged, place))
        self._dragged = None


def known_stages(settings: PipelineSettings) -> list[str]:
    """Return the names of all stages, those of the user's own among them."""
    STAGES.load(settings.plugins)
    return stage_names()


def _small(icon: str, does: str, enabled: bool, clicked: Callable[[], None], place: int) -> None:
    button = tip(ui.button(icon=icon).props("flat dense round size=xs"), does).mark(f"{does} {place}")
    button.on("click.stop", lambda: clicked())
    button.set_enabled(enabled)


def _shape(state: State) -> tuple[object, ...]:
    tuning = state.tuning
    return tuple(stage["use"] for stage in tuning.config.pipeline.chain()), tuning.bypassed
