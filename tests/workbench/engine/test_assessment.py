"""The chart inside is that of `ods assess detect`, on fewer images."""

import numpy as np
import pytest

from ods.assess.detection.measure import score_of
from ods.assess.images.sea import sea_images
from ods.base.files.shipped import shipped_file
from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.sonar.model import load_sonar
from ods.workbench.engine import assessment
from ods.workbench.engine.assessment import SONAR, even_values, measured, numbers_of, spacing_m, swept
from ods.workbench.engine.background.own_process import whole
from ods.workbench.engine.measuring import images, point_of
from ods.workbench.model.actions import SetSetting
from ods.workbench.model.apply import apply
from ods.workbench.model.paths import PathError
from ods.workbench.model.state import State
from tests.workbench.model.test_history import LAST

FEW = 2
"""Images."""
HIGH = f"pipeline.stage[{LAST}].high"


def test_the_images_are_the_first_of_those_of_ods_assess() -> None:
    pings, own = images(FEW), sea_images(FEW, assessment.IMAGES_SEED)
    assert [each.ping.data for each in pings] == [each.ping.data for each in own]
    assert own[0].ping.dr_m == spacing_m() == load_sonar(shipped_file(SONAR)).dr_m


def test_the_point_has_what_the_chain_finds_at_its_own_levels() -> None:
    point = point_of("mine", PipelineSettings(), FEW)
    own = score_of(PipelineSettings(), images(FEW))
    assert (point.found_as_set, point.false_as_set) == (own.detection_probability, own.false_per_image)
    assert point.interval[0] <= point.found <= point.interval[1]
    assert point.ms > 0.0


def test_a_higher_level_finds_less_and_errs_less() -> None:
    reported: list[float] = []

    def tell(share: float) -> bool:
        reported.append(share)
        return True

    points = swept(tell, State(), HIGH, [4.0, 8.0, 100.0], FEW)
    assert points is not None
    assert [point.value for point in points] == [4.0, 8.0, 100.0]
    assert points[0].false_alarms > points[1].false_alarms >= points[2].false_alarms == 0.0
    assert points[0].found >= points[1].found >= points[2].found
    assert reported == [0.0, 1 / 3, 2 / 3]


def test_values_that_a_setting_refuses_are_left_out() -> None:
    points = swept(whole, State(), HIGH, [-1.0, 8.0], FEW)
    assert points is not None
    assert [point.value for point in points] == [8.0]
    with pytest.raises(PathError, match="high"):
        swept(whole, State(), HIGH, [-1.0], FEW)


def test_a_sweep_ends_when_it_is_not_wanted_any_more() -> None:
    assert swept(lambda share: share == 0.0, State(), HIGH, [8.0, 9.0], FEW) is None
    assert measured(lambda share: share == 0.0, {}, ["FIR 9", "box 5"], FEW) is None


def test_a_number_that_is_swept_is_the_one_that_runs_and_changes_no_other() -> None:
    cells = f"pipeline.stage[{LAST}].min_cells"
    (reported,) = [each for each in numbers_of(State().tuning) if each.path == cells]
    assert reported.value == 2
    points = swept(whole, State(), cells, [2], FEW)
    assert points is not None
    (swept_to_it,) = points
    own = score_of(PipelineSettings(), images(FEW))
    assert (swept_to_it.found, swept_to_it.false_alarms) == (own.detection_probability, own.false_per_image)


def test_values_run_from_end_to_end() -> None:
    assert even_values(1.0, 3.0, 5, by_factors=False, whole=False) == [1.0, 1.5, 2.0, 2.5, 3.0]
    assert even_values(1.0, 3.0, 5, by_factors=False, whole=True) == [1, 2, 3]
    np.testing.assert_allclose(even_values(0.01, 1.0, 3, by_factors=True, whole=False), [0.01, 0.1, 1.0])


def test_all_numbers_of_the_chain_can_be_swept() -> None:
    numbers = numbers_of(State().tuning)
    assert numbers[0].path == f"pipeline.stage[{LAST}].connectivity"
    assert (HIGH, 5.5, False) in [(each.path, each.value, each.whole) for each in numbers]
    for each in numbers:
        state = apply(State(), SetSetting(each.path, int(each.value) if each.whole else each.value))
        assert state.tuning.pipeline().chain()[LAST]["use"] == "detect.two_level"
