"""Echograms: no peak is lost and none is moved, whatever the pings' ranges; memory is bounded."""

from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.base.arrays import Floats32
from ods.messages import Ping
from ods.recording.errors import RecordingError
from ods.workbench.engine.data import Data
from ods.workbench.engine.echogram import levels
from ods.workbench.engine.echogram.levels import Echogram, Filling, levels_along, read_echogram, title_of
from ods.workbench.engine.echogram.paper import pooled
from ods.workbench.model.state import DataReference
from tests.pipeline.pings import make_ping
from tests.range_images import ping_of

PEAK = 200


def ping(samples: int = 40, peak: tuple[int, int] = (1, 20), number: int = 0, **changes: Any) -> Ping:
    """Return one of 4 beams with a single strong sample."""
    frame = np.full((4, samples), 2, np.uint8)
    frame[peak] = PEAK
    return make_ping(frame, ping_number=number, t_ns=10**9 * (number + 1), **changes)


def peak_m(levels: Floats32, cell_m: float) -> float:
    """Return the range of the middle of the highest cell."""
    return cell_m * (int(np.nanargmax(levels)) + 0.5)


geometries = st.tuples(st.floats(0.0, 30.0), st.floats(0.01, 1.0), st.integers(2, 90))


@given(st.lists(geometries, min_size=1, max_size=5), st.sampled_from([8, 64, 256]), st.integers(1, 5), st.data())
def test_each_pings_peak_stays_at_its_range(
    made: list[tuple[float, float, int]], most_cells: int, most_columns: int, drawn: st.DataObject
) -> None:
    filling = Filling(len(made), None, most_columns, most_cells)
    at: list[tuple[float, float]] = []
    for place, (range0_m, dr_m, samples) in enumerate(made):
        sample = drawn.draw(st.integers(0, samples - 1))
        filling.add(place, ping(samples, (2, sample), range0_m=range0_m, dr_m=dr_m))
        at.append((range0_m + sample * dr_m, dr_m))
    result = filling.result()
    assert result.level_db.shape[0] <= most_columns
    assert result.level_db.shape[1] <= most_cells
    highest = np.nanmax(result.level_db)
    for place, (range_m, dr_m) in enumerate(at):
        column = result.level_db[place // result.per_column]
        centres = result.cell_m * (np.flatnonzero(column >= highest - 1e-3) + 0.5)
        assert np.abs(centres - range_m).min() <= result.cell_m + dr_m


def test_of_a_long_mission_one_ping_in_a_column_is_not_lost() -> None:
    filling = Filling(5000)
    quiet = ping(peak=(0, 0))
    for place in range(5000):
        filling.add(place, ping(peak=(3, 30)) if place == 3001 else quiet)
    result = filling.result()
    assert (result.per_column, len(result.level_db)) == (3, 1667)
    strong = np.argwhere(result.level_db[:, 1:] > 20.0)
    assert strong[:, 0].tolist() == [1000]
    assert strong[:, 1].tolist() == [29]
    assert result.t_s[0] == 0.0


def test_another_range_setting_leaves_what_was_before_where_it_was() -> None:
    filling = Filling(2, most_cells=64)
    filling.add(0, ping(40, (1, 20)))  # 2 m
    filling.add(1, ping(40, (1, 20), dr_m=0.5))  # 20 m
    result = filling.result()
    for column, range_m in zip(result.level_db, (1.0, 10.0), strict=True):
        assert peak_m(column, result.cell_m) == pytest.approx(range_m, abs=result.cell_m)
    assert np.isnan(result.level_db[0][int(3.0 / result.cell_m) :]).all()  # nothing was received from there


def test_a_beam_and_the_highest_of_all_planes() -> None:
    made = msgspec.structs.replace(ping(8, (3, 5)), planes=2, bearing_rad=[-0.1, 0.1] * 2)
    assert np.nanargmax(levels_along(made, None)) == 5
    assert levels_along(made, 1)[5] == pytest.approx(20.0 * np.log10(PEAK + 0.5))
    assert levels_along(made, 0)[5] == pytest.approx(20.0 * np.log10(2.5))
    assert np.isnan(levels_along(made, 2)).all()


def test_a_range_image_has_its_echoes_at_their_ranges() -> None:
    ranges = np.zeros((64, 256), np.float32)
    ranges[20:30, 100] = 6.0
    filling = Filling(1)
    filling.add(0, ping_of(ranges))
    result = filling.result()
    assert peak_m(result.level_db[0], result.cell_m) == pytest.approx(6.0, abs=result.cell_m)


def test_samples_without_data_are_none() -> None:
    made = ping(8, (1, 5), no_data=[(beam, 0, 2) for beam in range(4)] + [(1, 4, 8)])
    levels = levels_along(made, None)
    assert np.isnan(levels).tolist() == [True, True, *[False] * 6]
    assert levels[5] == pytest.approx(20.0 * np.log10(2.5))
    assert np.isnan(levels_along(made, 1)).tolist() == [True, True, False, False, *[True] * 4]


class Torn(list[Ping]):
    """Pings of which the second cannot be read."""

    def __getitem__(self, place: Any) -> Any:
        if place == 1:
            raise RecordingError("torn")
        return super().__getitem__(place)


def test_what_cannot_be_read_is_an_empty_column(monkeypatch: pytest.MonkeyPatch) -> None:
    data = Data(DataReference(), Torn([ping(number=number) for number in range(3)]))
    result = read_echogram(data)
    assert result is not None
    assert np.isnan(result.level_db).all(axis=1).tolist() == [False, True, False]
    assert result.t_s.tolist()[::2] == [0.0, 2.0]
    monkeypatch.setattr(levels, "SHOW_S", -1.0)
    parts: list[Echogram] = []

    def tell(part: Echogram) -> bool:
        parts.append(part)
        return part.read < 2

    assert read_echogram(data, report=tell) is None
    assert [part.read for part in parts] == [1, 1, 2]


def test_a_title_says_what_is_shown() -> None:
    empty = Echogram(np.zeros((2, 1), np.float32), 4, 2, 1.0, 4, np.array([-0.1, 0.0]), np.zeros(2))
    assert title_of(empty, None) == (
        "Echogram of 4 pings, 2 pings per column: the highest: the highest level of all beams"
    )
    assert title_of(empty, 1).endswith("beam 1 at +0.0°")
    assert title_of(empty, 9).endswith("beam 9: there is none")


def test_paper_loses_no_peak_either() -> None:
    levels = np.random.default_rng(1).random((301, 77)).astype(np.float32)
    levels[200, 50] = np.nan
    small = pooled(levels, 100, 10)
    assert small.shape == (100, 10)
    assert np.nanmax(small) == np.nanmax(levels)
    np.testing.assert_array_equal(pooled(levels, 400, 100), levels)
