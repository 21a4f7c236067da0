"""Undo and redo of everything, each step under a name."""

from typing import NamedTuple

import msgspec

from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.naming import name_of
from ods.workbench.model.state import State

LONGEST = 500
"""Steps that can be undone; older ones are forgotten. States share what did not change."""


class Done(NamedTuple):
    """A step, and what came of it."""

    name: str
    action: do.Action | None
    """None: the beginning."""
    state: State


class History(NamedTuple):
    """Steps, of which the first `at` + 1 are done and the others undone. Immutable."""

    steps: tuple[Done, ...] = (Done("start", None, State()),)
    at: int = 0

    @classmethod
    def of(cls, state: State) -> "History":
        """Begin with a state."""
        return cls((Done("start", None, state),))

    @property
    def state(self) -> State:
        """As it is now."""
        return self.steps[self.at].state

    @property
    def undoes(self) -> str:
        """Name of the step that `undone` takes back; empty: there is none."""
        return self.steps[self.at].name if self.at else ""

    @property
    def redoes(self) -> str:
        """Name of the step that `redone` does again; empty: there is none."""
        return self.steps[self.at + 1].name if self.at + 1 < len(self.steps) else ""

    def after(self, action: do.Action) -> "History":
        """Do an action. What was undone is forgotten, but by a change of the ping, which is no step. Raises PathError.

        Steps that follow each other and set the same thing, as a slider that is dragged, are one.
        """
        before = self.steps[self.at]
        state = apply(before.state, action)
        if isinstance(action, do.ShowPing):
            return self._with(before._replace(state=state))
        if state == before.state:
            return self
        first = self.at
        if self.at and _same_thing(before.action, action):
            first -= 1
        name = name_of(action, self.steps[first].state)
        steps = (*self.steps[: first + 1], Done(name, action, state))[-LONGEST:]
        return History(steps, len(steps) - 1)

    def undone(self) -> "History":
        """Take the last step back, if there is one; the ping that is shown stays."""
        return self.moved_to(self.at - 1)

    def redone(self) -> "History":
        """Do again what was taken back last, if anything was."""
        return self.moved_to(self.at + 1)

    def moved_to(self, at: int) -> "History":
        """Undo or redo up to a step of the list."""
        if not 0 <= at < len(self.steps):
            return self
        ping, data = self.state.ping, self.state.data
        moved = History(self.steps, at)
        if moved.state.data != data:
            return moved
        return moved._with(moved.steps[at]._replace(state=msgspec.structs.replace(moved.state, ping=ping)))

    def _with(self, done: Done) -> "History":
        return History((*self.steps[: self.at], done, *self.steps[self.at + 1 :]), self.at)

    def actions(self) -> list[do.Action]:
        """Return what was done and not undone, from the beginning."""
        return [step.action for step in self.steps[1 : self.at + 1] if step.action is not None]


def _same_thing(before: do.Action | None, action: do.Action) -> bool:
    if isinstance(before, do.SetSetting) and isinstance(action, do.SetSetting):
        return before.path == action.path
    if isinstance(before, do.SetScene) and isinstance(action, do.SetScene):
        return before.path == action.path
    return isinstance(before, do.SetView) and isinstance(action, do.SetView) and before.name == action.name
