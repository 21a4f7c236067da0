"""The gallery of demos: each has a state to start from, pictures made once, and explanations."""

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import msgspec

from ods import __version__
from ods.base.files.shipped import FOLDER as SHIPPED, shipped_file
from ods.base.settings_file import load
from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.engine.files.openable import Openable, openable
from ods.workbench.model.scene.edits import scene_of
from ods.workbench.model.short_tables import short_tables
from ods.workbench.model.state import DataReference, State

SOURCES = SHIPPED.resolve().parent / "tests" / "data"
"""Where recordings lie in the source tree; they are not in wheels."""
SONAR = "seabat6012"
LOST = list(range(120, 165))
"""Pings of the bench with faults that are lost whole: 6.7 s."""


class Demo(NamedTuple):
    """Something to show."""

    key: str
    title: str
    look: tuple[str, str, str]
    """Three sentences on what to look at."""
    scene: SceneFile | None = None
    file: Path | None = None
    """A recording, where it is no scene."""
    missing: str = ""
    """Why it cannot be shown; empty: it can."""

    def state(self, base: State) -> State:
        """Return what the other menus show of it; configuration and view are those of `base`."""
        path = str(self.file or "")
        data = DataReference("file", path) if self.file is not None else DataReference("scene", path, SONAR)
        return State(tuning=base.tuning, view=base.view, data=data, scene=self.scene or base.scene)

    def digest(self, base: State) -> str:
        """Return what the pictures depend on as one word: version, configuration, scene or file."""
        stat = self.file.stat() if self.file is not None else None
        tables = [__version__, self.title, short_tables(base.tuning), self.scene and short_tables(self.scene)]
        text = msgspec.json.encode([*tables, stat and [str(self.file), stat.st_size, stat.st_mtime_ns]], order="sorted")
        return hashlib.sha256(text).hexdigest()[:16]


class DemoResult(msgspec.Struct):
    """Text cached with the pictures of a demo."""

    facts: str
    pictures: list[str]


def demos(folders: Sequence[Path]) -> list[Demo]:
    """Return all demos: the simulated ones, and the recordings that are found under folders or in the sources."""
    places = [*folders, SOURCES] if SOURCES.is_dir() else list(folders)
    found = openable(places)
    return [*_simulated(), *(_recorded(each, found) for each in _RECORDED)]


def _simulated() -> list[Demo]:
    return [
        Demo(key, title, look, _shipped(scene) if isinstance(scene, str) else scene_of(scene))
        for key, title, scene, look in (
            ("figure11", "Figure 11", "figure11_imperfect", _FIGURE_11),
            ("worked_example", "Worked example, figures 6 and 7", "worked_example", _WORKED),
            ("rough", "Rough sea-bed", "rough_figure11", _ROUGH),
            ("approach", "Closest approach", _APPROACH_SCENE, _APPROACH),
            ("faults", "Bench with faults", _faults_scene(), _FAULTS),
        )
    ]


def _shipped(name: str) -> SceneFile:
    return load(shipped_file(f"scenes/{name}.toml"), SceneFile)


class _Kind(NamedTuple):
    key: str
    title: str
    suffix: str
    look: tuple[str, str, str]


def _recorded(kind: _Kind, found: Sequence[Openable]) -> Demo:
    files = [each.path for each in found if each.path.suffix.lower() == kind.suffix]
    file = next((path for path in files if kind.suffix != ".avi" or path.with_suffix(".toml").is_file()), None)
    missing = ""
    if file is None and files:
        beside = files[0].with_suffix(".toml").name
        missing = f"{files[0].name}: its fan's geometry, {beside} beside it, is not there (docs/recordings/formats.md)"
    elif file is None:
        missing = f"no {kind.suffix} file under the workbench's folders; `--folder DIR` adds one"
    return Demo(kind.key, kind.title, kind.look, file=file, missing=missing)


def _faults_scene() -> dict[str, object]:
    tables = short_tables(_shipped("faults"))
    lost = {"range_m": 50.0, "width_m": 1000.0, "gain_db": -60.0, "pings": LOST}
    return tables | {"image": tables.get("image", {}) | {"dropouts": [lost]}}


_APPROACH_SCENE: dict[str, object] = {
    "seed": 17,
    "duration_s": 40.0,
    "vehicle": {"position_ned": [0.0, 0.0, 10.0], "velocity_ned": [1.0, 0.0, 0.0]},
    "objects": [
        {
            "shape": "sphere", "name": "crosses", "position_ned": [65.0, 36.0, 10.5], "velocity_ned": [-0.2, -0.8, 0.0],
            "radius_m": 2.0, "surface": {"cd": 0.1, "cs": 0.05},
        },
        {
            "shape": "sphere", "name": "rests", "position_ned": [60.0, -18.0, 11.0], "radius_m": 1.5,
            "surface": {"cd": 0.1, "cs": 0.05},
        },
    ],
    "sea_bed": {"depth_m": 26.0, "surface": {"cd": 0.5, "cs": 0.2, "sigma_deg": 20.0}},
}  # fmt: skip
"""What crosses passes 7 m ahead of where the vehicle would be."""

_FIGURE_11 = (
    "Three objects lie on a flat sea-bed, whose reverberation rises where the main lobe meets it, from 18 m on.",
    "The dark arcs at 78 and 82 m are drop-outs, the dark and the light belt are errors of the TVG; the bright patch "
    "to starboard is another sonar.",
    "Equalization removes all of these, so that only the three objects are detected and tracked.",
)
_WORKED = (
    "The vehicle goes north for 80 s while two objects move; each is tracked with its radius (figure 6).",
    "Object 1 leaves the sector at 41 s: its track waits in stand-by and ends, while the truth goes on, dashed.",
    "The tracks' velocities come to the true ones, dashed (figure 7); vertical ones are not observable with one plane.",
)
_ROUGH = (
    "The sea-bed has heights of 8 cm rms, and its highlights look like small objects.",
    "Objects cast shadows here, which end where the bottom behind them is seen again.",
    "Highlights come and go from ping to ping, objects stay: count the false tracks.",
)
_APPROACH = (
    "One object crosses the vehicle's path from starboard, another is static to port.",
    "Menu Observer shows the time and distance of each closest approach, and their uncertainty.",
    "Move the vehicle's speed in menu Simulator and rehearse again: the approach follows.",
)
_FAULTS = (
    f"From ping {LOST[0]} to {LOST[-1]} the images are lost: nothing is detected, and no new object appears.",
    "The tracks wait in stand-by with growing uncertainty, and continue with their ids when the images return.",
    "`ods bench --config config/bench-faults.toml` does this to real processes, which are killed and unplugged.",
)
_RECORDED = (
    _Kind("aris", "ARIS, real", ".aris", (
        "An imaging sonar with a telephoto lens looks at the sea-bed and at straight structures, 3 to 23 m away.",
        "Its beams are a third of a degree apart, and its speckle is as strong as theory says (1.1 looks).",
        "The circles are the default chain's detections; real frames have no truth.",
    )),
    _Kind("oculus", "Oculus, real", ".raw", (
        "A tank at 2.1 MHz, over 2 m: the near wall and the bottom are saturated in places.",
        "Nothing moves, so all pings are almost the same, including the speckle.",
        "256 beams that are not evenly spaced go through the same chain as the 60 of the SeaBat.",
    )),
    _Kind("didson", "DIDSON, real", ".avi", (
        "Fish pass over a river's bed, filmed from a screen: a clip of fan images, which are sampled back to beams.",
        "The bed is static, fish move: step through the pings in menu Image processing.",
        "Numbers and lines that the software drew into the clip become echoes, too.",
    )),
)  # fmt: skip
