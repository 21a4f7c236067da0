"""Exponential back-off."""

import pytest

from ods.runtime.port.backoff import Backoff


def test_each_failure_doubles_the_delay_up_to_the_longest() -> None:
    backoff = Backoff(0.1, 1.0)
    assert [backoff.failed() for _ in range(6)] == pytest.approx([0.1, 0.2, 0.4, 0.8, 1.0, 1.0])


def test_it_begins_anew_when_something_worked() -> None:
    backoff = Backoff(0.1, 1.0)
    for _ in range(4):
        backoff.failed()
    backoff.worked()
    assert backoff.failed() == pytest.approx(0.1)


def test_a_day_of_failures_overflows_nothing() -> None:
    backoff = Backoff(0.5, 86_400.0)
    assert max(backoff.failed() for _ in range(100_000)) == 86_400.0


def test_no_first_delay_stays_none() -> None:
    backoff = Backoff(0.0, 5.0)
    assert [backoff.failed() for _ in range(3)] == [0.0, 0.0, 0.0]


def test_the_longest_delay_may_be_shorter_than_the_first() -> None:
    assert Backoff(3.0, 2.0).failed() == 2.0


def test_asking_for_a_delay_counts_nothing() -> None:
    backoff = Backoff(1.0, 10.0)
    assert backoff.delay_s(3) == 4.0
    assert backoff.failed() == 1.0
