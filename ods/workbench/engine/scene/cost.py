"""What the parts of a scene's image cost, table 1 of [SSIE]; the simulator is loaded when it is measured."""

from collections.abc import Callable, Mapping
from typing import NamedTuple

from ods.sim_sonar.by_name import find_sonar
from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.engine.scene.view import built


class Cost(NamedTuple):
    """CPU times of one image."""

    parts_ms: dict[str, float]
    """Under the names of table 1."""
    period_s: float
    paper_s: Mapping[str, float]
    """Table 1."""


def cost_of(_: Callable[[float], bool], file: SceneFile, sonar: str) -> Cost:
    """Measure the parts of an image of a scene: a second or so. Raises OdsError."""
    from ods.simulate.speed import QUICK, TABLE_1, parts_of

    model = find_sonar(sonar)
    return Cost(parts_of(model, built(file), QUICK), model.ping_period_s, TABLE_1)
