"""Metrics of detection against cases worked by hand."""

import numpy as np
import pytest

from ods.assess.detection.measure import stability
from ods.assess.detection.metrics import (
    Score,
    at_false_alarms,
    edge_preservation,
    interval_at_false_alarms,
    nearest_score,
    noise_suppression_db,
    pareto_front,
)
from ods.assess.images.labelled import Target, circle_target
from ods.assess.track.measure import ratio_interval
from ods.messages import Detection, Detections, Sector

pytestmark = pytest.mark.slow


def detection(range_m: float, bearing_rad: float, radius_m: float = 1.0) -> Detection:
    return Detection(range_m, bearing_rad, radius_m, 5.0, 3.0, 14.0, 9, 1.0, 0.1, 0.1, 0.01, 0.1)


def frame(*places: tuple[float, float]) -> Detections:
    sector = Sector(
        range_min_m=0.0, range_max_m=100.0, bearing_min_rad=-0.5, bearing_max_rad=0.5, half_vertical_rad=0.1
    )
    found = [detection(*place) for place in places]
    return Detections(0, 0, 0, 0, 0, 1500.0, sector, found)


def test_score_counts_targets_false_alarms_and_errors() -> None:
    body = circle_target(50.0, 0.0, 2.0, margin_m=1.0, margin_rad=0.01)
    score = Score()
    # found twice (counts once, no false alarm), the nearer one is measured: 0.5 m off, radius 3 for 2; one false alarm
    score.count_image([detection(50.5, 0.0, 3.0), detection(52.9, 0.0), detection(20.0, 0.3)], [body])
    # missed: 3.1 m too far; that is a false alarm too
    score.count_image([detection(53.1, 0.0)], [body])
    assert (score.images, score.targets, score.found, score.false_alarms) == (2, 2, 1, 2)
    assert (score.detection_probability, score.false_per_image) == (0.5, 1.0)
    assert score.position_error_m == pytest.approx([0.5])
    assert score.radius_error == pytest.approx([0.5])


def test_position_error_across_is_the_chord() -> None:
    score = Score()
    target = Target((9.0, 11.0), (-0.5, 0.5), (10.0, 0.0, 1.0))
    score.count_image([detection(10.0, np.radians(20.0))], [target])
    assert score.position_error_m == pytest.approx([2 * 10.0 * np.sin(np.radians(10.0))])


def test_targets_that_do_not_count_and_boxes_without_circles() -> None:
    score = Score()
    faint = Target((10.0, 20.0), (-0.1, 0.1), counts=False)
    box = Target((30.0, 40.0), (-0.1, 0.1))
    score.count_image([detection(15.0, 0.0), detection(35.0, 0.0)], [faint, box])
    assert (score.targets, score.found, score.false_alarms, score.position_error_m) == (1, 1, 0, [])


def test_no_image_and_no_target_are_zero() -> None:
    assert (Score().detection_probability, Score().false_per_image) == (0.0, 0.0)


def swept(*points: tuple[int, int]) -> list[Score]:
    return [Score(images=10, targets=10, found=found, false_alarms=false) for found, false in points]


def test_detection_probability_at_a_number_of_false_alarms() -> None:
    scores = swept((2, 1), (6, 100))  # 0.1 and 10 false alarms an image: 1 lies half-way in the logarithm
    assert at_false_alarms(scores, 1.0) == pytest.approx(0.4)
    assert at_false_alarms(scores, 10.0) == pytest.approx(0.6)
    assert at_false_alarms(scores, 99.0) == pytest.approx(0.6)  # the sweep ends there
    assert at_false_alarms(scores, 0.05) == 0.0  # never that few
    assert at_false_alarms([], 1.0) == 0.0
    assert at_false_alarms(swept((7, 0), (6, 100)), 1.0) == pytest.approx(0.7)  # a worse point does not harm
    assert nearest_score(scores, 2.0) == 1
    assert nearest_score(scores, 0.9) == 0


def test_interval_is_that_of_the_binomial_law() -> None:
    """100 images of one object each, half of them found, one false alarm in each: 0.5 +- 1.96 sqrt(0.25 / 100)."""
    score = Score(100, 100, 50, 100, by_image=[(1, k % 2, 1) for k in range(100)])
    low, high = interval_at_false_alarms([score], 1.0)
    assert (low, high) == pytest.approx((0.402, 0.598), abs=0.03)
    alike = Score(20, 20, 20, 20, by_image=[(1, 1, 1)] * 20)
    assert interval_at_false_alarms([alike], 1.0) == (1.0, 1.0)
    assert np.isnan(interval_at_false_alarms([Score(1, 1, 1, 1, by_image=[(1, 1, 1)])], 1.0)).all()
    assert np.isnan(interval_at_false_alarms([], 1.0)).all()


def test_interval_of_a_ratio_is_paired() -> None:
    """Seeds that are hard for the tracker are hard for the reference: a ratio that never changes has no interval."""
    hard = np.array([1.0, 2.0, 5.0, 0.5, 3.0])
    assert ratio_interval((1.2 * hard).tolist(), hard.tolist()) == pytest.approx((1.2, 1.2))
    low, high = ratio_interval([1.0, 2.0, 1.5], [1.0, 1.0, 1.0])
    assert 1.0 <= low < 1.5 < high <= 2.0
    assert np.isnan(ratio_interval([1.0], [1.0])).all()


def test_noise_suppression_of_a_mean_over_four_samples_is_six_decibels() -> None:
    rng = np.random.default_rng(1)
    before = rng.normal(10.0, 1.0, (50, 4000)).astype(np.float32)
    after = before.reshape(50, 1000, 4).mean(axis=2).repeat(4, axis=1)
    quiet = np.ones(before.shape, np.bool_)
    assert noise_suppression_db(before, after, quiet) == pytest.approx(20 * np.log10(2.0), abs=0.1)
    assert noise_suppression_db(before, before, quiet) == 0.0


def test_edge_preservation() -> None:
    step = np.zeros((2, 12), np.float32)
    step[:, 4:8] = 1.0
    ramp = np.zeros((2, 12), np.float32)
    ramp[:, 3:9] = [0.5, 1.0, 1.0, 1.0, 1.0, 0.5]
    # differences +1 at one place and -1 at another against halves at two places each: 2 * 0.5 / sqrt(2 * 1) a row
    assert edge_preservation(step, 3.0 * step) == pytest.approx(1.0)
    assert edge_preservation(step, ramp) == pytest.approx(1.0 / np.sqrt(2.0))
    assert edge_preservation(step, 1.0 - step) == pytest.approx(-1.0)
    assert edge_preservation(step, np.ones_like(step)) == 0.0


def test_pareto_front_is_what_nothing_beats_in_both() -> None:
    ms = [3.0, 1.0, 2.0, 2.0, 4.0, 1.0]
    accuracy = [0.9, 0.5, 0.7, 0.8, 0.9, 0.4]
    assert pareto_front(ms, accuracy) == [1, 3, 0]
    assert pareto_front([], []) == []


def test_stability_counts_what_the_next_frame_shows_again() -> None:
    # 2 % of 100 m and of 1 rad: the first echo stays, the second moves by 3 m, the third by 0.03 rad
    frames = [frame((10.0, 0.0), (50.0, 0.0), (90.0, 0.0)), frame((11.9, 0.019), (53.0, 0.0), (90.0, 0.03)), frame()]
    clusters, again = stability(frames)
    assert clusters == pytest.approx(2.0)
    assert again == pytest.approx(1.0 / 6.0)
    assert np.isnan(stability([frame(), frame()])[1])
