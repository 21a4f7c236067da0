"""The time of a movie is the mission's."""

import pytest

from ods.base.clock import MS
from ods.track.movie import GIF_UNIT_MS, LEAST_MS, shown


@pytest.mark.parametrize("unit_ms", [1, GIF_UNIT_MS])
@pytest.mark.parametrize("period_ms", [150.7, 33.3, 20.0, 15.0, 4.0])
def test_frames_last_as_long_as_the_mission_and_none_shorter_than_browsers_show(period_ms: float, unit_ms: int) -> None:
    times = [5_000 + round(k * period_ms * MS) for k in range(100)]
    places, spans = shown(times, unit_ms)
    assert min(spans) >= LEAST_MS
    assert all(span % unit_ms == 0 for span in spans)
    for place, until in zip(places[1:], range(1, len(places)), strict=True):
        assert sum(spans[:until]) == pytest.approx(place * period_ms, abs=0.5 * unit_ms + 1e-3)
    assert 99 - places[-1] <= LEAST_MS / period_ms + 1


def test_one_picture_stands_alone() -> None:
    assert shown([7], 10) == ([0], [])


def test_times_that_go_back_leave_frames_out() -> None:
    assert shown([0, 100 * MS, 50 * MS, 200 * MS], 10) == ([0, 1, 3], [100, 100])
