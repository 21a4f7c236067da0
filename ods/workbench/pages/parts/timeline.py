"""The timeline under the pictures: any ping, marks to go to, playing at any speed."""

from collections.abc import Callable
from functools import partial

from nicegui import ui
from nicegui.events import KeyEventArguments

from ods.workbench.engine.background.newest import Newest
from ods.workbench.engine.mission.marks import Kind, Mark, bookmark_marks, thinned, track_marks
from ods.workbench.engine.mission.moments import Moments
from ods.workbench.engine.mission.rerun import wanted
from ods.workbench.model.actions import ShowPing
from ods.workbench.model.state import State
from ods.workbench.pages.parts.reruns import rerun_of
from ods.workbench.pages.parts.tips import tip
from ods.workbench.session import Session
from ods.workbench.web.follow import follow, in_loop
from ods.workbench.web.views.scrubber import Scrubber

SPEEDS = {0.25: "x 1/4", 0.5: "x 1/2", 1.0: "x 1", 2.0: "x 2", 5.0: "x 5", 20.0: "x 20"}
STEPS = {"ArrowLeft": -1, "ArrowRight": 1}
PLAY_S = 0.2
"""Between pings, where their times are not known."""
MOST_MARKS = 120
"""Of a kind."""
REPORTED: tuple[Kind, ...] = ("new", "lost")
"""Kinds of marks that come from the tracker's lists."""
SIGNS: dict[Kind, tuple[str, str]] = {
    "new": ("▲", "text-teal-5"), "lost": ("▽", "text-blue-4"), "gap": ("✕", "text-red-5"),
    "bookmark": ("★", "text-amber-7"),
}  # fmt: skip
"""Sign and colour."""


class Timeline:
    """One row. `show` takes when pings were, and the ping that is shown."""

    def __init__(self, session: Session, is_ready: Callable[[], bool], hold: Callable[[bool], None]) -> None:
        """is_ready: whether the page shows what was asked for last, so that playing may go on; hold: called when the
        hand drags the timeline, and that it has let go."""
        self._session, self._is_ready, self._hold = session, is_ready, hold
        self._moments: Moments | None = None
        self._gaps: list[Mark] = []
        self._drawn: tuple[int, list[tuple[Mark, bool]]] = (0, [])
        """The last place, and the marks that are shown, with those that are dimmed."""
        self._rerun = rerun_of(session)
        with ui.row().classes("w-full items-end no-wrap gap-2"):
            self._build()
        self._reader: Newest[Moments, list[Mark]] = Newest(self._read, self._found, lambda *_: None)
        client = ui.context.client
        client.on_delete(self._reader.close)
        client.on_delete(self._rerun.listen(lambda: in_loop(self._bar, self._draw)))
        follow(session, self._bar, self._follow)

    def _build(self) -> None:
        self._plays = ui.timer(PLAY_S, self._next, active=False)
        self._play = ui.button(icon="play_arrow", on_click=self.toggle_play).props("dense flat round").mark("play")
        tip(self._play, "play, and stop (space)")
        self._speed = ui.select(SPEEDS, value=1.0, on_change=self._set_speed).props("dense options-dense borderless")
        tip(self._speed, "speed of playing").mark("speed")
        self._track = ui.button(icon="flag", on_click=self._find).props("dense flat round").mark("find objects")
        tip(self._track, "mark where objects come and go: tracks the mission as the menu Observer does")
        with ui.column().classes("grow min-w-0 gap-0"):
            self._bar = ui.element("div").classes("relative w-full h-4 text-xs").mark("marks")
            self._ping = Scrubber(self._scrub).mark("ping")
        self._time = ui.label("").classes("text-sm w-56 text-right")

    def show(self, moments: Moments, place: int) -> None:
        """Show where among the pings one is."""
        self._ping.show(place, max(moments.count - 1, 1))
        when = "" if moments.t_s is None else f", {moments.t_s(place):.2f} s"
        self._time.set_text(f"ping {place} of {moments.count}{when}")
        if moments is not self._moments:
            self._moments, self._gaps = moments, []
            self._reader.ask(moments)
            self._draw()
        self._set_speed()

    def press(self, event: KeyEventArguments) -> None:
        """Do what a key says: play and stop, or another ping."""
        if event.key.name == " " and not event.action.repeat:
            self.toggle_play()
        elif event.key.name.lower() == "n":
            self._go_to_mark(-1 if event.modifiers.shift else 1)
        elif self._moments is not None and event.key.name in STEPS:
            step = STEPS[event.key.name] * (10 if event.modifiers.shift else 1)
            self._go(min(max(self._session.state.ping + step, 0), self._moments.count - 1))

    def _go_to_mark(self, step: int) -> None:
        """Go to the next mark, or to the one before."""
        now = self._session.state.ping
        ahead = [mark.place for mark, _ in self._drawn[1] if (mark.place - now) * step > 0]
        if ahead:
            self._go(min(ahead) if step > 0 else max(ahead))

    def toggle_play(self) -> None:
        """Play, or stop."""
        self._plays.active = not self._plays.active
        self._play.set_icon("pause" if self._plays.active else "play_arrow")

    def _set_speed(self) -> None:
        self._plays.interval = ((self._moments and self._moments.period_s) or PLAY_S) / self._speed.value

    def _next(self) -> None:
        """Show the next ping, once this one is shown."""
        if self._moments is not None and self._is_ready():
            self._session.do(ShowPing((self._session.state.ping + 1) % self._moments.count))

    def _scrub(self, place: int, held: bool) -> None:
        self._go(place)
        self._hold(held)

    def _go(self, place: int) -> None:
        if place != self._session.state.ping:
            self._session.do(ShowPing(place))

    # -- marks --
    def _find(self) -> None:
        self._rerun.ask(wanted(self._session.state))
        self._draw()

    def _read(self, moments: Moments) -> list[Mark]:
        return moments.gaps(lambda: self._reader.overtaken)

    def _found(self, moments: Moments, marks: list[Mark]) -> None:
        def take() -> None:
            if moments is self._moments:
                self._gaps = marks
                self._draw()

        in_loop(self._bar, take)

    def _follow(self, before: State, after: State) -> None:
        if before.bookmarks != after.bookmarks or wanted(before) != wanted(after):
            self._draw()

    def _draw(self) -> None:
        """Show all marks that are known; those of objects that other settings found are dimmed."""
        rerun, wish, moments = self._rerun, wanted(self._session.state), self._moments
        runs = rerun.progress is not None
        self._track.props(add="loading") if runs else self._track.props(remove="loading")
        last = 0 if moments is None else moments.count - 1
        result, of = rerun.result, rerun.result_of
        tracks = track_marks(result) if result is not None and of is not None and of[:2] == wish[:2] else []
        known = [*self._gaps, *tracks, *bookmark_marks(self._session.state.bookmarks)] if last else []
        drawn = last, [(mark, mark.kind in REPORTED and of != wish) for mark in thinned(known, last, MOST_MARKS)]
        if drawn == self._drawn:
            return
        self._drawn = drawn
        self._bar.clear()
        with self._bar:
            for mark, dim in drawn[1]:
                self._sign(mark, last, dim=dim)

    def _sign(self, mark: Mark, last: int, *, dim: bool) -> None:
        sign, colour = SIGNS[mark.kind]
        label = ui.label(sign).classes(f"absolute cursor-pointer leading-none {colour}")
        label.style(f"left: {100 * min(mark.place, last) / last:.3f}%; transform: translateX(-50%); bottom: 0")
        label.classes("opacity-50" if dim else "").mark(f"mark {mark.kind} {mark.place}")
        label.tooltip(f"ping {mark.place}: {mark.text}").on("click", partial(self._go, mark.place))
