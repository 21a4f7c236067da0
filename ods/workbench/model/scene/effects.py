"""What may be wrong with a simulated image, each with a switch of its own."""

from typing import Any, NamedTuple

from ods.sim_sonar.scene.settings import SceneFile
from ods.workbench.model.actions import SetScene
from ods.workbench.model.history import History
from ods.workbench.model.paths import PathError, value_at, with_value


class Effect(NamedTuple):
    """One effect of a scene."""

    label: str
    path: str
    """In SceneFile."""
    off: Any
    """Value without it."""
    example: Any
    """Value with it, in a scene that never had it."""
    of_image: bool = True
    """False: it belongs to the surroundings, not to sonar and water."""


BELTS = [
    {"from_m": 50.0, "to_m": 60.0, "gain_db": -5.0, "edge_m": 2.0},
    {"from_m": 70.0, "to_m": 80.0, "gain_db": 4.0, "edge_m": 2.0},
]
"""Those of figure 11's real image, as are the drop-outs."""
DROPOUTS = [
    {"range_m": 78.0, "width_m": 0.6, "gain_db": -20.0},
    {"range_m": 82.0, "width_m": 0.8, "gain_db": -20.0},
]
DROP_INS = [{"width_m": 0.5, "chance": 0.3, "gain_db": 12.0}]
PULSES = [{"position_ned": [60.0, 40.0, 20.0], "level_counts": 800.0, "period_s": 0.031, "pulse_s": 0.0005}]

EFFECTS = (
    Effect("speckle", "image.speckle", False, True),
    Effect("receiver noise", "image.noise_counts", 0.0, 30.0),
    Effect("speckle as long as a pulse", "image.range_correlation", 0.0, 0.2),
    Effect("drop-outs", "image.dropouts", [], DROPOUTS),
    Effect("drop-ins", "image.drop_ins", [], DROP_INS),
    Effect("TVG belts", "image.belts", [], BELTS),
    Effect("TVG set wrong", "image.tvg.set_spreading_db", None, 30.0),
    Effect("uneven beams", "image.beam_gain_rms_db", 0.0, 0.5),
    Effect("interference", "image.interference", [], PULSES),
    Effect("saturation", "image.saturation_counts", 1e9, 2000.0),
    Effect("shadows", "shadows", False, True, False),
    Effect("sea-bed", "sea_bed", None, {"depth_m": 23.1}, False),
    Effect("rough sea-bed", "sea_bed.rough", None, {"rms_height_m": 0.08, "correlation_m": 3.0, "facets": 200}, False),
)
NOISE = "image.noise_counts"
"""It raises the mean of an image, as the sea-bed does, and so stays in what is expected of a perfect sonar."""


def is_on(scene: SceneFile, effect: Effect) -> bool:
    """Return whether a scene has an effect."""
    try:
        return bool(value_at(scene, effect.path) != effect.off)
    except PathError:
        return False  # there is no sea-bed that could be rough


def switch(history: History, effect: Effect, on: bool) -> SetScene:
    """Return the action that switches an effect: on again as it was last, or as in its example."""
    if not on:
        return SetScene(effect.path, effect.off)
    for step in reversed(history.steps[: history.at + 1]):
        if step.state.scene is not None and is_on(step.state.scene, effect):
            return SetScene(effect.path, value_at(step.state.scene, effect.path))
    return SetScene(effect.path, effect.example)


def perfect(scene: SceneFile) -> SceneFile:
    """Return a scene as a perfect sonar would see it: the mean image, with nothing wrong."""
    for effect in EFFECTS:
        if effect.of_image and effect.path != NOISE and is_on(scene, effect):
            scene = with_value(scene, effect.path, effect.off)
    return with_value(scene, "image.beam_gain_db", [])
