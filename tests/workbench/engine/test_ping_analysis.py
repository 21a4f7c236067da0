"""Studies against the chain that runs on board, and looks against plain numpy."""

from collections.abc import Sequence
from typing import Any

import msgspec
import numpy as np
import pytest

from ods.base.errors import OdsError
from ods.messages import Ping, Pose
from ods.offline.mission import MissionSettings
from ods.pipeline.chain import Chain
from ods.pipeline.prepared.filter_chain import FilterChain
from ods.pipeline.stage.watch import StageImage
from ods.plots.polar import level_db
from ods.workbench.engine.data import Data
from ods.workbench.engine.ping import analysis
from ods.workbench.engine.ping.analysis import FORMER_PINGS, OvertakenError, PingAnalysis, PingAnalyzer
from ods.workbench.engine.ping.look import BINS, HIGHEST_DB, LOWEST_DB, Look, coded, histogram, profile
from ods.workbench.model.state import DataReference
from tests.pipeline.pings import body_echo, fan_bearings, make_ping, speckle

BEAMS, SAMPLES = 32, 400
CODED = 2.0**-9
"""Relative error of an amplitude that is kept as a code: rounded to eight bits."""
SHORT: list[dict[str, Any]] = [
    {"use": "equalize.mean_range"},
    {"use": "filter.fir", "taps": 9},
    {"use": "detect.two_level", "follow": 0.0},
]
OVER_PINGS: list[dict[str, Any]] = [{"use": "filter.ping_iir"}, {"use": "detect.two_level", "follow": 0.0}]


def settings(stages: Sequence[Any] = SHORT, **pipeline: Any) -> MissionSettings:
    return msgspec.convert({"pipeline": {"stage": stages, **pipeline}}, MissionSettings)


def pings(count: int = 3, **changes: Any) -> list[Ping]:
    rng = np.random.default_rng(1)
    echo = 900.0 * body_echo("disc", 0.6, 12.0, 0.1, fan_bearings(BEAMS), SAMPLES)
    return [
        make_ping(
            (30.0 * speckle(rng, 1.0 + echo)).clip(0, 255).astype(np.uint8),
            seq=number, ping_number=number, t_ns=10**9 + number * 10**8, **changes,
        )
        for number in range(count)
    ]  # fmt: skip


def data(made: list[Ping], poses: Sequence[Pose] = ()) -> Data:
    return Data(DataReference(kind="file"), made, poses)


def test_a_study_has_what_the_chain_finds_and_shows() -> None:
    made = pings()
    shown: list[StageImage] = []
    expected = Chain(settings().pipeline, watch=shown.append).process(made[1])
    analysis = PingAnalyzer(data(made)).analyze(settings(), 1)
    assert analysis.detections == expected
    assert expected.detections
    assert [look.label for look in analysis.looks] == [each.label for each in shown]
    for look, each in zip(analysis.looks, shown, strict=True):
        if look.label != "recorded":  # of which ranges below the least one are shown, too
            finite = np.isfinite(look.image)
            np.testing.assert_allclose(look.image[finite], each.image.ravel(), rtol=CODED)
    assert analysis.looks[-1].levels == shown[-1].levels
    assert analysis.attended.sum() == shown[0].image.size


def test_the_recorded_image_is_whole() -> None:
    made = pings()
    analysis = PingAnalyzer(data(made)).analyze(settings(min_range_m=5.0), 0)
    amplitude = 10.0 ** (level_db(made[0]) / 20.0)
    np.testing.assert_allclose(analysis.looks[0].image, amplitude, rtol=CODED + 1e-4)
    assert not np.isfinite(analysis.looks[1].image[:, :99]).any()
    assert np.isfinite(analysis.looks[1].image[:, 100:]).all()


def test_places_of_the_chain_are_counted_with_those_that_are_bypassed() -> None:
    analysis = PingAnalyzer(data(pings())).analyze(settings([SHORT[0], SHORT[2]]), 0)
    labels = [analysis.after(place, (1,)).label for place in (-1, 0, 1, 2)]
    assert labels == ["recorded", "equalize.mean_range", "equalize.mean_range", "detect.two_level"]


def test_attention_goes_by_the_ping_s_place() -> None:
    analyzer = PingAnalyzer(data(pings(6)))
    focused = settings(attention={"near_m": 6.0, "every": 3, "margin_m": 1.0, "subsample": 2})
    for place in (4, 0, 5, 3):
        analysis = analyzer.analyze(focused, place)
        ranges = analysis.grid.range_m
        processed = np.asarray(analysis.attended.any(axis=0))
        for near, far in analysis.detections.processed_ranges_m:
            inside = (ranges > max(near, 0.2)) & (ranges < min(far, ranges[-2]))
            assert processed[inside].all()
        begin = 6.0 + (ranges[-1] + 0.05 - 6.0) * (place % 3) / 3
        assert analysis.detections.processed_ranges_m[1][0] == pytest.approx(begin)
        assert not processed[(ranges > 8.0) & (ranges < begin - 1.5)].any()


@pytest.mark.parametrize("place", [0, 2, FORMER_PINGS - 1])
def test_a_chain_over_pings_has_seen_those_before(place: int) -> None:
    made = pings(FORMER_PINGS)
    chain = Chain(settings(OVER_PINGS).pipeline)
    expected = [chain.process(ping) for ping in made[: place + 1]][-1]
    analyzer = PingAnalyzer(data(made))
    assert analyzer.analyze(settings(OVER_PINGS), place).detections == expected
    assert analyzer.analyze(settings(OVER_PINGS), place).detections == expected


def test_going_on_from_ping_to_ping_is_as_jumping_there() -> None:
    made = pings(6)
    walking, jumping = PingAnalyzer(data(made)), PingAnalyzer(data(made))
    steps = [walking.analyze(settings(OVER_PINGS), place).looks[1].image for place in range(6)]
    assert np.array_equal(steps[-1], jumping.analyze(settings(OVER_PINGS), 5).looks[1].image, equal_nan=True)


def test_costs_are_reported_for_each_stage() -> None:
    analyzer = PingAnalyzer(data(pings()))
    analyzer.analyze(settings(), 0)
    assert analyzer.cost(settings(), 0, lambda: True) is None
    cost = analyzer.cost(settings(), 0, lambda: False)
    assert cost is not None
    assert [name for name, _ in cost.stages] == [stage["use"] for stage in SHORT]
    assert all(time_us > 0.0 for _, time_us in cost.stages)
    assert cost.whole >= sum(time_us for _, time_us in cost.stages)
    assert cost.prepared > 0.0


@pytest.mark.parametrize(
    ("made", "wanted", "place"),
    [
        (pings(dr_m=0.0), settings(), 0),
        (pings(), settings(), 3),
        (pings(), settings([{"use": "detect.two_level"}, {"use": "filter.fir"}]), 0),
        (pings(), settings(min_range_m=500.0), 0),
    ],
)
def test_what_cannot_be_done_is_one_line(made: list[Ping], wanted: MissionSettings, place: int) -> None:
    with pytest.raises(OdsError) as refused:
        PingAnalyzer(data(made)).analyze(wanted, place)
    assert "\n" not in str(refused.value)


def test_planes_are_shown_as_one_by_their_highest_levels() -> None:
    rng = np.random.default_rng(3)
    frame = rng.integers(1, 200, (2 * BEAMS, SAMPLES), np.uint8)
    ping = make_ping(
        frame, planes=2, bearing_rad=[*fan_bearings(BEAMS)] * 2, elevation_rad=[-0.1] * BEAMS + [0.1] * BEAMS
    )
    analysis = PingAnalyzer(data([ping])).analyze(settings(min_range_m=0.0), 0)
    assert analysis.looks[0].image.shape == (BEAMS, SAMPLES)
    levels = 20.0 * np.log10(frame.reshape(2, BEAMS, SAMPLES).max(axis=0) + 0.5)
    np.testing.assert_allclose(20.0 * np.log10(analysis.looks[0].image), levels, atol=0.02)


def look(image: Any, levels: tuple[float, float] | None = None) -> Look:
    image = np.asarray(image, np.float32)
    return Look("some", np.where(np.isnan(image), np.uint16(0), coded(image)), levels)


def test_levels_are_decibels_over_the_median() -> None:
    some = look([[1.0, 2.0, 4.0, np.nan, 20.0]], (3.0, 30.0))
    assert some.unit == pytest.approx(3.0)
    np.testing.assert_allclose(
        some.level_db()[0, [0, 1, 2, 4]], 20.0 * np.log10(np.array([1, 2, 4, 20]) / 3.0), rtol=1e-5
    )
    assert some.levels_db is not None
    np.testing.assert_allclose(some.levels_db, (0.0, 20.0), atol=1e-6)
    assert some.amplitude_of(some.db_of(7.0)) == pytest.approx(7.0)
    assert profile(some, 0).shape == (5,)


def test_histograms_count_every_cell_that_was_processed() -> None:
    rng = np.random.default_rng(2)
    image = rng.exponential(size=(20, 300))
    image[3, :50], image[5, 3], image[6, 4] = np.nan, 0.0, 1e9
    some = look(image)
    counted = histogram(some)
    levels = some.level_db()
    levels = levels[np.isfinite(levels)].clip(LOWEST_DB, HIGHEST_DB)
    assert counted.cells.sum() == 5950
    below = np.cumsum(counted.cells)[:-1]
    edges = np.linspace(LOWEST_DB, HIGHEST_DB, BINS + 1)[1:-1, None]
    near = 1e-3  # dB: processors round what lies at the very edges of bins to either side
    assert ((levels < edges - near).sum(1) <= below).all()
    assert (below <= (levels < edges + near).sum(1)).all()


def test_a_study_s_looks_belong_to_it_for_good() -> None:
    analyzer = PingAnalyzer(data(pings()))
    first: PingAnalysis = analyzer.analyze(settings(), 0)
    kept = [each.image.copy() for each in first.looks]
    analyzer.analyze(settings(), 1)
    for each, before in zip(first.looks, kept, strict=True):
        assert np.array_equal(each.image, before, equal_nan=True)


@pytest.mark.parametrize(
    "change",
    [{"high": 9.0}, {"levels": "false_alarm", "rate": 1e-4}, {"use": "detect.cfar", "high": None, "rate": 1e-3}],
)
def test_a_detector_learns_from_kept_speckle_what_it_learns_on_board(change: dict[str, Any]) -> None:
    made = pings(1)
    analyzer = PingAnalyzer(data(made))
    first: dict[str, Any] = {"use": "detect.two_level", "high": 6.0}
    changed = {key: value for key, value in (first | change).items() if value is not None}
    for last in (first, changed, first):
        wanted = settings([*SHORT[:2], last])
        shown: list[StageImage] = []
        expected = Chain(wanted.pipeline, watch=shown.append).process(made[0])
        analysis = analyzer.analyze(wanted, 0)
        assert analysis.detections == expected
        assert analysis.looks[-1].levels == shown[-1].levels


def test_another_setting_of_a_detector_filters_no_speckle(monkeypatch: pytest.MonkeyPatch) -> None:
    analyzer = PingAnalyzer(data(pings(1)))
    filtered: list[int] = []
    whole = FilterChain.run

    def run(self: FilterChain, *args: Any, **named: Any) -> Any:
        filtered.append(1)
        return whole(self, *args, **named)

    monkeypatch.setattr(FilterChain, "run", run)
    counts = []
    for stages in ([*SHORT[:2], {"use": "detect.two_level"}], [*SHORT[:2], {"use": "detect.two_level", "high": 7.0}],
                   [SHORT[0], {"use": "detect.two_level", "high": 7.0}]):  # fmt: skip
        filtered.clear()
        analyzer.analyze(settings(stages), 0)
        counts.append(len(filtered))
    assert counts[1] == 1  # the ping alone
    assert min(counts[0], counts[2]) > 8


@pytest.mark.parametrize(("shown", "prepared"), [(1, [True, True, True]), (2, [True, True, False])])
def test_large_chains_are_kept_as_many_as_are_shown(
    monkeypatch: pytest.MonkeyPatch, shown: int, prepared: list[bool]
) -> None:
    monkeypatch.setattr(analysis, "KEPT_CELLS", BEAMS * SAMPLES)
    analyzer = PingAnalyzer(data(pings(1)))
    made: list[int] = []

    def build(*args: Any) -> Any:
        made.append(1)
        return whole(*args)

    whole = analysis._Prepared
    monkeypatch.setattr(analysis, "_Prepared", build)
    for high, anew in zip((6.0, 7.0, 6.0), prepared, strict=True):
        made.clear()
        analyzer.analyze(settings([*SHORT[:2], {"use": "detect.two_level", "high": high, "follow": 0.0}]), 0, shown)
        assert bool(made) == anew


def test_long_learning_is_given_up_for_what_is_newer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(analysis, "PATIENCE_S", -1.0)
    newer = [False, False, True]
    analyzer = PingAnalyzer(data(pings()), lambda: newer.pop(0) if newer else False)
    wanted = settings([*SHORT[:2], {"use": "detect.cfar"}])
    with pytest.raises(OvertakenError):
        analyzer.analyze(wanted, 1)
    assert newer == []  # the third image of speckle was the last
    assert analyzer.analyze(wanted, 1).detections == Chain(wanted.pipeline).process(pings()[1])
