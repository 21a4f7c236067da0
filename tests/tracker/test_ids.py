"""Ids are small, whatever happens at the start, and none is given twice."""

from ods.base import clock
from ods.tracker.restart.checkpoint import Checkpoints
from ods.tracker.restart.ids import ABOVE_ALL, ID_BLOCK, MOST_A_MISSION, PROVISIONAL_IDS, first_of, provisional_first_id
from tests.tracker.played import good, played
from tests.tracker.test_checkpoint import CONFIG


def test_provisional_ids_fit_in_32_bits_and_none_of_them_is_an_ordinary_one() -> None:
    starts = [provisional_first_id() for _ in range(1000)]
    assert min(starts) >= PROVISIONAL_IDS
    assert max(starts) + MOST_A_MISSION < ABOVE_ALL == 2**31
    assert len(set(starts)) > 990


def test_ids_go_on_where_the_farther_of_map_and_former_tracker_left_off_but_not_at_a_provisional_one() -> None:
    assert first_of(of_map=1041, of_former=2000) == 2000
    assert first_of(of_map=1041, of_former=7) == 1041
    assert first_of(of_map=1041, of_former=provisional_first_id() + ID_BLOCK) == 1041
    assert first_of(of_map=1041, of_former=2**40 + 2**52) == 1041  # as versions of before gave


def test_ids_are_small_again_after_a_tracker_that_could_not_read_the_map() -> None:
    with played() as chain:
        chain.until(good)
        chain.kill()
        left = Checkpoints(chain.folder, CONFIG, lambda name, line: None)
        left.write(clock.monotonic_ns(), 2**40 + 5000, None)
        chain.lists.clear()
        chain.start()
        assert max(o.id for o in chain.until(good).obstacles) < 10 * ID_BLOCK
