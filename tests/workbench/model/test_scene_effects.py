"""The switches of a scene's effects."""

import pytest

from ods.sim_sonar.by_name import find_scene
from ods.workbench.model import actions as do
from ods.workbench.model.history import History
from ods.workbench.model.scene.effects import EFFECTS, Effect, is_on, perfect, switch
from ods.workbench.model.state import State

WHOLE = find_scene("rough_figure11").file
BY_PATH = {effect.path: effect for effect in EFFECTS}


def test_a_scene_tells_which_effects_it_has() -> None:
    """figure11_imperfect.toml over a rough sea-bed, as its comment says."""
    on = {effect.label for effect in EFFECTS if is_on(WHOLE, effect)}
    assert on == {
        "speckle", "receiver noise", "speckle as long as a pulse", "drop-outs", "drop-ins", "TVG belts", "uneven beams",
        "interference", "shadows", "sea-bed", "rough sea-bed",
    }  # fmt: skip
    assert not is_on(find_scene("empty").file, BY_PATH["sea_bed.rough"])


@pytest.mark.parametrize("effect", EFFECTS, ids=lambda effect: effect.path)
def test_every_effect_can_be_switched_both_ways(effect: Effect) -> None:
    history = History.of(State(scene=WHOLE))
    for on in (False, True, False):
        history = history.after(switch(history, effect, on))
        assert history.state.scene is not None
        assert is_on(history.state.scene, effect) == on


def test_what_was_off_comes_back_as_it_was() -> None:
    history = History.of(State(scene=WHOLE)).after(do.SetScene("image.belts[0].gain_db", -9.0))
    before = history.state.scene
    history = history.after(switch(history, BY_PATH["image.belts"], False))
    history = history.after(do.SetScene("seed", 3))
    history = history.after(switch(history, BY_PATH["image.belts"], True))
    assert before is not None
    assert history.state.scene is not None
    assert history.state.scene.image == before.image


def test_a_perfect_sonar_hears_noise_and_sea_bed_still() -> None:
    clean = perfect(WHOLE)
    on = {effect.label for effect in EFFECTS if is_on(clean, effect)}
    assert on == {"receiver noise", "shadows", "sea-bed", "rough sea-bed"}
