"""Pages of the stages of the chain, and of the files that the simulator reads: scenes and sonars."""

import inspect
from collections.abc import Sequence

import msgspec

from ods.base.frames.mounting import MountingSettings
from ods.pipeline.stage.configured import find_stage, stage_names
from ods.pipeline.stage.params import GroupParams
from ods.reference.markdown import head
from ods.reference.setting_pages import Seen, Table, key_table, sections, tables
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.sonar.settings import SonarFile

FOLDER = "Configuration"
TOP = "-"
"""Stands for the file itself in the path of a table."""


def file_pages() -> dict[str, str]:
    """Return the pages: name and text."""
    seen = Seen()
    seen.kinds[MountingSettings] = "sonar.mounting"
    seen.whole.add(MountingSettings)
    scene = tables(SceneFile, TOP, seen)
    images = [table for table in scene if table.path.startswith(f"{TOP}.image")]
    stages = [name for name in stage_names() if find_stage(name).params.__module__.startswith("ods.pipeline.")]
    detectors = [name for name in stages if name.startswith("detect.")]
    others = [name for name in stages if name not in detectors]
    shared = f"\n## All detectors\n\n{key_table(GroupParams)}"
    return {
        "configuration/stages.md": _stages("equalizers and filters", others),
        "configuration/detectors.md": _stages("detectors", detectors, shared),
        "configuration/scene.md": _file("scene files", [each for each in scene if each not in images]),
        "configuration/image.md": _file("images of scene files", images),
        "configuration/sonar-file.md": _file("sonar files", tables(SonarFile, TOP, Seen())),
    }


def _stages(title: str, names: Sequence[str], text: str = "") -> str:
    known = [field.name for field in msgspec.structs.fields(GroupParams)]
    for name in names:
        params = find_stage(name).params
        about = (inspect.getdoc(params) or "").removeprefix(f"{name}: ")
        own = key_table(params, known if issubclass(params, GroupParams) else (), f"{about[:1].upper()}{about[1:]}")
        text += f"\n## {name}\n\n{own}"
    return f"{head(FOLDER, title)}\n[What they are for](../pipeline/README.md#other-stages).\n{text}"


def _file(title: str, found: Sequence[Table]) -> str:
    text = sections(found).replace(f"## [{TOP}]", "## The file").replace(f"[{TOP}.", "[")
    return f"{head(FOLDER, title)}\n[Scenes and sonars](../simulator/README.md#sonar-and-scene-files).\n{text}"
