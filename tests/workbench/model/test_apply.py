"""What single actions do."""

import tomllib

import msgspec
import numpy as np
import pytest
import tomli_w

from ods.base.files.shipped import shipped_file
from ods.sim_sonar.scene.motion import Motion
from ods.sim_sonar.scene.timeline import load_scene
from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.scene.edits import scene_of
from ods.workbench.model.short_tables import short_tables
from ods.workbench.model.state import State
from tests.workbench.model.test_history import LAST, SCENE, START


def test_the_first_change_of_the_default_chain_writes_it_out() -> None:
    after = apply(START, do.SetSetting(f"pipeline.stage[{LAST}].high", 7.0))
    chain = after.tuning.config.pipeline.stage
    assert [stage["use"] for stage in chain] == [stage["use"] for stage in START.tuning.config.pipeline.chain()]
    assert chain[LAST]["high"] == 7.0


def test_a_bypass_moves_with_its_stage() -> None:
    state = apply(START, do.BypassStage(0, True))
    name = state.tuning.config.pipeline.chain()[0]["use"]
    state = apply(state, do.MoveStage(0, 2))
    assert state.tuning.bypassed == (2,)
    assert state.tuning.config.pipeline.chain()[2]["use"] == name
    assert name not in [stage["use"] for stage in state.tuning.pipeline().chain()]


def test_b_stays_as_it_was_kept() -> None:
    state = apply(apply(START, do.KeepAsB()), do.SetSetting("tracker.observer", "independent"))
    assert state.other == START.tuning
    swapped = apply(state, do.SwapAB())
    assert (swapped.tuning, swapped.other) == (START.tuning, state.tuning)


def test_c_and_d_stay_as_they_were_kept_and_go_with_b() -> None:
    state = apply(START, do.KeepAsB())
    kept = []
    for fewest in (3, 4, 5):
        state = apply(apply(state, do.SetSetting("tracker.life.confirm_echoes", fewest)), do.KeepAsNext())
        kept.append(state.tuning)
    assert state.further == (kept[0], kept[2])  # the last D
    assert apply(state, do.DropB()) == msgspec.structs.replace(state, other=None, further=())


def test_a_first_waypoint_keeps_the_ends_of_the_straight_path() -> None:
    state = apply(START, do.AddWaypoint("objects[0]", 30.0, (25.0, 10.0, 5.0)))
    assert state.scene is not None
    path = Motion(state.scene.objects[0])
    assert path.position(np.float64(0.0)) == pytest.approx(Motion(SCENE.objects[0]).position(np.float64(0.0)))
    assert path.position(np.float64(60.0)) == pytest.approx(Motion(SCENE.objects[0]).position(np.float64(60.0)))
    assert path.position(np.float64(30.0)) == pytest.approx((25.0, 10.0, 5.0))


@pytest.mark.parametrize("name", ["figure11", "rough_figure11", "worked_example", "faults", "sea/kelp"])
def test_a_scene_written_shortly_is_the_same_scene(name: str) -> None:
    scene = load_scene(shipped_file(f"scenes/{name}.toml")).file
    assert scene_of(tomllib.loads(tomli_w.dumps(short_tables(scene)))) == scene


def test_what_is_as_by_default_is_not_written() -> None:
    state = apply(State(), do.SetSetting("tracker.echo.loss_rate", 0.01))
    assert short_tables(state.tuning.config) == {"tracker": {"echo": {"loss_rate": 0.01}}}
