"""Actions of a workbench: each is plain data, that can be recorded, written down and done again."""

from typing import Any, Literal

import msgspec

from ods.workbench.model.state import Beside, DataReference, Label, State, Tuning

Place = tuple[float, float, float]
ShapeName = Literal["sphere", "cylinder", "plane"]


class Action(msgspec.Struct, frozen=True, forbid_unknown_fields=True, tag_field="do"):
    """Base of all actions; `do` distinguishes them in JSON."""


class SetSetting(Action, frozen=True, tag="set"):
    """Give one setting of A another value."""

    path: str
    """In MissionSettings: "pipeline.stage[2].high", "tracker.observer"."""
    value: Any


class AddStage(Action, frozen=True, tag="add_stage"):
    """Put a stage into the chain of A, with its default parameters."""

    use: str
    at: int


class RemoveStage(Action, frozen=True, tag="remove_stage"):
    """Take a stage out."""

    at: int


class MoveStage(Action, frozen=True, tag="move_stage"):
    """Put a stage to another place."""

    at: int
    to: int


class BypassStage(Action, frozen=True, tag="bypass_stage"):
    """Leave a stage out for now, or take it in again."""

    at: int
    on: bool


class WriteNumbers(Action, frozen=True, tag="write_numbers"):
    """Write the numbers into the chain that follow from the smallest object, as they are; nothing else changes."""

    dr_m: float
    """Spacing of the range samples."""


class SetTuning(Action, frozen=True, tag="set_tuning"):
    """Take another configuration for A."""

    tuning: Tuning
    name: str
    """How the history calls it: a preset, a file."""


class SetState(Action, frozen=True, tag="set_state"):
    """Show all as in another state: of a preset, a link, the gallery."""

    state: State
    name: str
    """How the history calls it."""


class KeepAsB(Action, frozen=True, tag="keep_as_b"):
    """Keep today's configuration, so that what comes is compared with it."""


class KeepAsNext(Action, frozen=True, tag="keep_as_next"):
    """Keep today's configuration as C, or D, for the range profile; with both there, D is replaced."""


class SwapAB(Action, frozen=True, tag="swap"):
    """Exchange A and B."""


class DropB(Action, frozen=True, tag="drop_b"):
    """Compare no more."""


class OpenData(Action, frozen=True, tag="open"):
    """Take pings from elsewhere. The scene of State stays, unless `scene` brings another."""

    data: DataReference
    scene: dict[str, Any] | None = None
    """Tables of the scene's file."""


class ShowBeside(Action, frozen=True, tag="beside"):
    """Show a ping of other data beside the one at hand; none: no more."""

    beside: Beside | None


class ShowPing(Action, frozen=True, tag="ping"):
    """Go to a ping. Not a step of the history."""

    ping: int


class SetView(Action, frozen=True, tag="view"):
    """Show things otherwise."""

    name: str
    """A field of View."""
    value: Any


class SetBookmark(Action, frozen=True, tag="bookmark"):
    """Mark a ping; without a text the mark is taken away."""

    ping: int
    text: str


class AddLabel(Action, frozen=True, tag="add_label"):
    """Label something in a recording."""

    label: Label


class RemoveLabel(Action, frozen=True, tag="remove_label"):
    """Take a label away."""

    at: int


class SetLabels(Action, frozen=True, tag="set_labels"):
    """Take other labels for all."""

    labels: tuple[Label, ...]
    name: str
    """How the history calls it: a file."""


class SetScene(Action, frozen=True, tag="set_scene"):
    """Give one setting of the scene another value."""

    path: str
    """In SceneFile: "objects[0].radius_m", "vehicle.waypoints[1].position_ned", "sea_bed"."""
    value: Any


class AddObject(Action, frozen=True, tag="add_object"):
    """Put an object into the scene."""

    shape: ShapeName
    position_ned: Place


class CopyObject(Action, frozen=True, tag="copy_object"):
    """Put another object like one into the scene, moved with its whole path; at the end of the list."""

    at: int
    moved_ned: Place
    """m."""


class RemoveObject(Action, frozen=True, tag="remove_object"):
    """Take an object out."""

    at: int


class AddWaypoint(Action, frozen=True, tag="add_waypoint"):
    """Put a way-point into a path; a straight path becomes a curve through its beginning and end first."""

    of: str
    """Path in SceneFile: "vehicle" or "objects[2]"."""
    t_s: float
    position_ned: Place


class RemoveWaypoint(Action, frozen=True, tag="remove_waypoint"):
    """Take a way-point out of a path; of the last two none."""

    of: str
    at: int


Step = (
    SetSetting | AddStage | RemoveStage | MoveStage | BypassStage | WriteNumbers | SetTuning | SetState | KeepAsB
    | KeepAsNext | SwapAB | DropB | OpenData | ShowBeside | ShowPing | SetView | SetBookmark | AddLabel | RemoveLabel
    | SetLabels | SetScene | AddObject | CopyObject | RemoveObject | AddWaypoint | RemoveWaypoint
)  # fmt: skip
"""Any action; messages and macros are decoded as this."""
