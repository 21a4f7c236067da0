"""One setting, the smallest object that matters: what the default chain's numbers follow from."""

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.pipeline.chain import Chain
from ods.pipeline.settings import DEFAULT_STAGES, AttentionSettings, Columns, PipelineSettings, columns_of
from tests.pipeline.pings import body_echo, fan_bearings, make_ping, speckle


@pytest.mark.parametrize(
    ("object_m", "dr_m", "subsample", "wanted"),
    [
        (0.0, 0.05, 0, Columns(2, 80, 5, 0.2, 2)),  # automatic, whatever the spacing
        (0.0, 0.0028, 0, Columns(2, 80, 5, 0.2, 2)),
        (0.0, 0.2, 0, Columns(2, 80, 5, 0.2, 2)),
        (0.0, 0.05, 1, Columns(1, 160, 9, 0.1, 4)),  # whole images, as FIR 9 was made for
        (0.3, 0.05, 0, Columns(2, 80, 5, 0.2, 2)),  # the same six samples, reported in metres
        (0.3, 0.01, 0, Columns(10, 24, 5, 0.2, 2)),  # an ARIS: 30 samples an object
        (0.3, 0.0028, 0, Columns(16, 54, 11, 3.0 / (5.0 * 0.3 / 0.0028 / 16), 4)),  # an Oculus: no more than 16 to one
        (0.6, 0.2, 0, Columns(1, 160, 5, 0.2, 2)),  # three samples, none to spare
        (0.1, 0.2, 0, Columns(1, 160, 3, 0.3, 1)),  # smaller than a sample
        (50.0, 0.003, 0, Columns(16, 512, 97, 3.0 / 320.0, 43)),
    ],
)
def test_numbers_in_closed_form(object_m: float, dr_m: float, subsample: int, wanted: Columns) -> None:
    columns = columns_of(object_m, dr_m, subsample)
    assert columns._replace(cutoff=0.0) == wanted._replace(cutoff=0.0)
    assert columns.cutoff == pytest.approx(wanted.cutoff)


@given(
    object_m=st.floats(0.0, 50.0),
    dr_m=st.floats(1e-4, 5.0),
    subsample=st.integers(0, 16),
)
def test_numbers_are_ones_that_the_stages_take(object_m: float, dr_m: float, subsample: int) -> None:
    settings = PipelineSettings(smallest_object_m=object_m, attention=AttentionSettings(subsample=subsample))
    resolved = settings.at_spacing(dr_m)
    again = PipelineSettings(stage=resolved.stage, attention=resolved.attention)  # refuses what is out of range
    assert again.at_spacing(dr_m) == again == resolved
    columns = columns_of(object_m, dr_m, subsample)
    assert 1 <= columns.subsample <= 16
    assert 3 <= columns.taps <= 97
    if subsample == 0 and object_m > 3.0 * dr_m:  # not averaged to less than three columns
        assert object_m / (columns.subsample * dr_m) >= 3.0 - 1e-3


def test_values_of_the_configuration_win() -> None:
    own = (*DEFAULT_STAGES[:3], {"use": "filter.fir", "taps": 9}, DEFAULT_STAGES[-1])
    other = ({"use": "filter.box"}, {"use": "detect.two_level"})
    for stages in (own, other):
        resolved = PipelineSettings(stage=stages).at_spacing(0.05)
        assert (resolved.stage, resolved.attention.subsample) == (stages, 1)
    louder = (*DEFAULT_STAGES[:-1], DEFAULT_STAGES[-1] | {"high": 9.0})  # the default chain, but for its level
    resolved = PipelineSettings(stage=louder).at_spacing(0.05)
    assert (resolved.stage[3]["taps"], resolved.stage[4]["high"], resolved.attention.subsample) == (5, 9.0, 2)
    assert PipelineSettings(attention=AttentionSettings(subsample=3)).at_spacing(0.05).attention.subsample == 3


def test_the_chain_takes_the_numbers_of_each_ping_s_own_spacing() -> None:
    bearings = fan_bearings(60)
    intensity = 1.0 + 200.0 * body_echo("half", 1.5, 40.0, 0.1, bearings, 2000)
    samples = (10.0 * speckle(np.random.default_rng(0), intensity)).clip(0, 255).astype(np.uint8)
    fine, coarse = make_ping(samples), make_ping(samples[:, ::4].copy(), dr_m=0.2)
    settings = PipelineSettings(smallest_object_m=0.6)
    chain = Chain(settings)
    for ping in (fine, coarse, fine):
        (found,) = chain.process(ping).detections
        (wanted,) = Chain(settings.at_spacing(ping.dr_m)).process(ping).detections
        assert found == wanted
        assert found.near_m == pytest.approx(38.5, abs=0.5)


@pytest.mark.parametrize(
    ("stages", "size", "complaint"),
    [
        (
            ({"use": "filter.box"}, {"use": "detect.two_level"}),
            0.5,
            "smallest_object_m: needs the default",
        ),
        (
            ({"use": "filter.fir", "taps": 5}, {"use": "detect.two_level"}),
            0.5,
            "smallest_object_m: needs the default stages",
        ),
    ],
)
def test_a_size_that_would_decide_nothing_is_refused(
    stages: tuple[dict[str, object], ...], size: float, complaint: str
) -> None:
    with pytest.raises(ValueError, match=complaint):
        PipelineSettings(stage=stages, smallest_object_m=size)
