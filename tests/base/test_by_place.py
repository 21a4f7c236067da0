"""Items by place: what cannot be read is left out, and places are found as by looking at all."""

import pytest
from hypothesis import given, strategies as st

from ods.base.files.lazy_sequence import LazySequence, UnreadableItemError, place_after


class Numbers(LazySequence[int]):
    """None: an item that cannot be read."""

    def __init__(self, numbers: list[int | None]) -> None:
        self._numbers = numbers

    def __len__(self) -> int:
        return len(self._numbers)

    def item(self, place: int) -> int:
        number = self._numbers[place]
        if number is None:
            raise UnreadableItemError(f"{place}")
        return number


def test_items_are_those_of_a_list_without_the_unreadable() -> None:
    numbers = Numbers([3, None, 5, 7])
    assert list(numbers) == [3, 5, 7]
    assert numbers[0:3] == [3, 5]
    assert numbers[-1] == 7
    with pytest.raises(UnreadableItemError):
        numbers[1]
    for beyond in (4, -5):
        with pytest.raises(IndexError):
            numbers[beyond]


@given(st.lists(st.integers(0, 20)).map(sorted), st.integers(-1, 21), st.sets(st.integers(0, 30)))
def test_the_place_after_a_value_is_that_behind_all_up_to_it(numbers: list[int], value: int, bad: set[int]) -> None:
    items = Numbers([None if place in bad else number for place, number in enumerate(numbers)])
    place = place_after(items, value, lambda number: number)
    assert items[:place] == [number for number in items if number <= value]
