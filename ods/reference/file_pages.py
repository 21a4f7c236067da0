"""Pages of the stages of the chain, and of the files that the simulator reads: scenes and sonars."""

import inspect
from collections.abc import Sequence

import msgspec

from ods.pipeline import built_in  # noqa: F401  it registers the stages that come with ODS
from ods.pipeline.stage.params import GroupParams
from ods.pipeline.stage.registry import find_stage, stage_names
from ods.reference.setting_pages import Seen, key_table, tables
from ods.reference.type_names import GENERATED
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.sonar.settings import SonarFile

TOP = "-"
"""Stands for the file itself in the path of a table."""


def file_pages() -> dict[str, str]:
    """Return the pages: name and text."""
    scene = tables(SceneFile, TOP, Seen())
    images = [(path, text) for path, text in scene if path.startswith(f"{TOP}.image")]
    stages = [name for name in stage_names() if find_stage(name).params.__module__.startswith("ods.pipeline.")]
    detectors = [name for name in stages if name.startswith("detect.")]
    others = [name for name in stages if name not in detectors]
    shared = f"\n## All detectors\n\n{inspect.getdoc(GroupParams)}\n\n{key_table(GroupParams)}"
    return {
        "configuration/stages.md": _stages("Stages: equalizers and filters", others),
        "configuration/detectors.md": _stages("Stages: detectors", detectors, shared),
        "configuration/scene.md": _file("Scene files", [each for each in scene if each not in images]),
        "configuration/image.md": _file("Scene files: the image", images),
        "configuration/sonar-file.md": _file("Sonar files", tables(SonarFile, TOP, Seen())),
    }


def _stages(title: str, names: Sequence[str], text: str = "") -> str:
    known = [field.name for field in msgspec.structs.fields(GroupParams)]
    for name in names:
        params = find_stage(name).params
        own = key_table(params, leave_out=known if issubclass(params, GroupParams) else ())
        about = (inspect.getdoc(params) or "").removeprefix(f"{name}: ")
        text += f"\n## {name}\n\n{about[:1].upper()}{about[1:]}\n\n{own}"
    links = "[How to read it](README.md), [what they are for](../pipeline/README.md#other-stages)"
    return f"# {title}\n\n{GENERATED} {links}.\n{text}"


def _file(title: str, sections: Sequence[tuple[str, str]]) -> str:
    text = "".join(section for _, section in sections)
    text = text.replace(f"## [{TOP}]", "## The file").replace(f"[{TOP}.", "[")
    return f"# {title}\n\n{GENERATED} [Scenes and sonars](../simulator/README.md#sonar-and-scene-files).\n{text}"
