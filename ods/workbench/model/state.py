"""The one state of a workbench: all that it shows follows from this and from the data that it names."""

from typing import Annotated, Literal

import msgspec

from ods.base.settings import NonNegativeInt, Settings
from ods.offline.mission import MissionSettings
from ods.pipeline.settings import PipelineSettings, leaves_numbers
from ods.sim_sonar.scene.settings import SceneFile


class Tuning(Settings, frozen=True):
    """A configuration that is being tuned."""

    config: MissionSettings = MissionSettings()
    bypassed: tuple[NonNegativeInt, ...] = ()
    """Places in the chain of stages that are left out for now, rising."""

    def pipeline(self) -> PipelineSettings:
        """Return what runs: the chain without the stages that are bypassed."""
        settings = self.config.pipeline
        if not self.bypassed:
            return settings
        kept = tuple(stage for place, stage in enumerate(settings.chain()) if place not in self.bypassed)
        smallest_m = settings.smallest_object_m if leaves_numbers(kept) else 0.0
        return msgspec.structs.replace(settings, stage=kept, smallest_object_m=smallest_m)

    def mission(self) -> MissionSettings:
        """Return the whole configuration that runs: with `pipeline()`."""
        return msgspec.structs.replace(self.config, pipeline=self.pipeline())


class DataReference(Settings, frozen=True):
    """Where pings come from."""

    kind: Literal["none", "file", "scene", "live"] = "none"
    """file: whatever `ods track` or `ods detect` read; scene: `State.scene`, simulated; live: a vehicle's bus."""
    path: str = ""
    """File, folder of segments, scene's file (empty: not saved yet) or run_dir."""
    sonar: str = "seabat6012"
    """That sees a scene."""


EchogramLayer = Literal["echoes", "tracks", "truth", "faults", "validity"]


class View(Settings, frozen=True):
    """How things are shown; nothing here changes a result."""

    presentation: Literal["fan", "polar"] = "fan"
    shown_stage: int = -1
    """Place in the chain of the stage after which the image is shown; -1: as recorded."""
    compared_stage: int | None = None
    """The same of a second picture beside it; none: one picture."""
    comparison: Literal["split", "blink", "difference"] = "split"
    """How A and B are shown, where there is a B."""
    palette: Literal["viridis", "cividis", "gray"] = "viridis"
    lowest_db: Annotated[float, msgspec.Meta(ge=-60.0, le=60.0)] = -5.0
    """Lower end of the colour scale, dB over the image's median."""
    highest_db: Annotated[float, msgspec.Meta(ge=-60.0, le=120.0)] = 30.0
    """Upper end."""
    attention: bool = False
    """Ranges that this ping skips are dimmed."""
    truth: bool = True
    """Where the truth is known, right, false and missed ones are distinguished."""
    chain_px: Annotated[int, msgspec.Meta(ge=280, le=900)] = 432
    """Width of the list of stages."""
    large: bool = False
    """Pictures have the window; stages and charts are folded away."""
    pinned_beam: int | None = None
    """Whose range profile is shown, however the mouse moves."""
    echogram_beam: NonNegativeInt | None = None
    """That the echogram shows; none: the highest level over all beams."""
    echogram_layers: tuple[EchogramLayer, ...] = ("echoes", "tracks", "truth", "faults", "validity")
    """What is shown over the echogram."""
    marked_obstacle: int | None = None
    """Id of the obstacle that is looked at."""
    dark: bool = True

    def __post_init__(self) -> None:
        if self.highest_db <= self.lowest_db:
            raise ValueError("highest_db: must be above lowest_db")


class Bookmark(Settings, frozen=True):
    """A ping worth coming back to."""

    ping: NonNegativeInt
    """Place in the recording."""
    text: str = ""


class Label(Settings, frozen=True):
    """Something in a recording that a detector ought to find, as a person sees it."""

    ping: NonNegativeInt
    """Place in the recording."""
    beams: tuple[NonNegativeInt, NonNegativeInt]
    """The first and the last, from port."""
    samples: tuple[NonNegativeInt, NonNegativeInt]
    """The first and the last."""
    shape: Literal["rectangle", "ellipse"] = "rectangle"
    """As it is drawn; what counts is the box around it."""
    text: Annotated[str, msgspec.Meta(max_length=80)] = ""
    """What it looks like."""

    def __post_init__(self) -> None:
        if self.beams[0] > self.beams[1] or self.samples[0] > self.samples[1]:
            raise ValueError("beams, samples: the first must not be above the last")
        if not self.text.isprintable() or "#" in self.text:
            raise ValueError("text: one line of plain text, without #")


class Beside(Settings, frozen=True):
    """Other data, of which a ping is shown beside the one at hand."""

    data: DataReference
    scene: SceneFile | None = None
    """Of `data`, where that is a scene."""


class State(Settings, frozen=True):
    """All that a workbench shows."""

    tuning: Tuning = Tuning()
    """A."""
    other: Tuning | None = None
    """B of A/B; none: nothing is compared."""
    further: Annotated[tuple[Tuning, ...], msgspec.Meta(max_length=2)] = ()
    """C and D, whose range profiles are shown beside those of A and B."""
    view: View = View()
    data: DataReference = DataReference()
    scene: SceneFile | None = None
    """That the simulator's menu edits."""
    ping: NonNegativeInt = 0
    """Place in the data of the ping that is shown."""
    bookmarks: tuple[Bookmark, ...] = ()
    """In order of pings."""
    beside: Beside | None = None
    """Seen through the same chain; none: nothing."""
    labels: Annotated[tuple[Label, ...], msgspec.Meta(max_length=5000)] = ()
    """Of a recording, in order of pings."""
