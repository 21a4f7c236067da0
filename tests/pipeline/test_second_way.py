"""Multipath: what stands behind all bodies by the same difference, and what only seems to."""

import math

import numpy as np
import pytest

from ods.messages import Detection
from ods.pipeline.interference.second_way import MultipathDetector
from tests.pipeline.pings import echo_table, make_ping


def echo(near_m: float, bearing_deg: float, snr_db: float, rng: np.random.Generator) -> Detection:
    near_m += rng.normal(0.0, 0.07)
    bearing = math.radians(bearing_deg + rng.normal(0.0, 0.2))
    level = 10.0 ** (snr_db / 20.0)
    return Detection(near_m, bearing, 0.5, 10.0, 5.0, snr_db, 30, 1.0, 0.05, 0.1, 0.01, 0.1, level, near_m=near_m)


HEARD_FROM_DB = 5.0
BODIES = [(30.0, -20.0, 24.0), (55.0, 3.0, 26.0), (70.0, 25.0, 22.0)]


def reported(longer_m: list[float], bodies: list[tuple[float, float, float]] = BODIES) -> list[list[float]]:
    rng, ways = np.random.default_rng(2), MultipathDetector()
    lists = []
    for number in range(20):
        ping = make_ping(np.ones((2, 2000), np.uint8), t_ns=number * 150_000_000)
        echoes = [echo(r - 0.15 * number, b, s, rng) for r, b, s in bodies]
        behind = [echo(r - 0.15 * number + m, b, s - 12.0, rng) for r, b, s in bodies for m in longer_m]
        behind = [each for each in behind if rng.random() < 0.9]
        lists.append(ways.of(ping, 0.0, echo_table(echoes), echo_table(behind), HEARD_FROM_DB))
    return lists


@pytest.mark.parametrize("longer_m", [3.0, 6.1, 17.3])
def test_a_way_is_reported_within_a_second_and_how_long_it_is(longer_m: float) -> None:
    for ways in reported([longer_m])[7:]:
        assert ways == pytest.approx([longer_m], abs=0.25)


def test_bodies_behind_bodies_are_none() -> None:
    """One behind another; a row of equals; and pairs that are not equally far apart."""
    assert not any(reported([], [*BODIES, (36.0, -20.0, 12.0)]))
    assert not any(reported([], [(20.0 + 6.0 * k, 5.0, 24.0) for k in range(6)]))
    assert not any(reported([], [*BODIES, (36.0, -20.0, 12.0), (65.0, 3.0, 13.0), (74.0, 25.0, 10.0)]))


def test_the_way_of_one_body_is_not_reported() -> None:
    assert not any(reported([6.0], BODIES[:1]))


def seen(
    bodies: list[tuple[float, float, float]], pings: range, ways: MultipathDetector, from_db: float
) -> list[float]:
    """Return what is reported after pings that show bodies and of each loud enough its echo, 6 m behind."""
    rng, reported = np.random.default_rng(3), []
    for number in pings:
        echoes = [echo(r, b, s, rng) for r, b, s in bodies]
        behind = [echo(r + 6.0, b, s - 12.0, rng) for r, b, s in bodies if s - 12.0 > from_db]
        ping = make_ping(np.ones((2, 2000), np.uint8), t_ns=number * 150_000_000)
        reported = ways.of(ping, 0.0, echo_table(echoes), echo_table(behind), from_db)
    return reported


def test_bodies_whose_echo_is_too_faint_say_nothing_against_a_way() -> None:
    loud, faint = [(30.0, -20.0, 26.0), (55.0, 3.0, 25.0)], [(70.0, 25.0, 18.0), (45.0, 30.0, 17.0), (62.0, -9.0, 16.0)]
    assert seen([*loud, *faint], range(10), MultipathDetector(), 10.0) == pytest.approx([6.0], abs=0.25)


def test_a_way_stays_while_no_body_or_only_one_can_show_it_and_goes_with_its_echoes() -> None:
    loud, faint = [(30.0, -20.0, 26.0), (55.0, 3.0, 25.0)], [(70.0, 25.0, 18.0), (45.0, 30.0, 17.0)]
    ways = MultipathDetector()
    seen(loud, range(10), ways, 10.0)
    assert seen(faint, range(10, 40), ways, 10.0) == pytest.approx([6.0], abs=0.25)
    assert seen([loud[0], *faint], range(40, 70), ways, 10.0) == pytest.approx([6.0], abs=0.25)
    rng = np.random.default_rng(5)
    for number in range(70, 84):
        ping = make_ping(np.ones((2, 2000), np.uint8), t_ns=number * 150_000_000)
        told_then = ways.of(ping, 0.0, echo_table([echo(*each, rng) for each in loud]), echo_table([]), 10.0)
    assert not told_then


def test_two_of_many_bodies_with_another_as_far_behind_by_chance_are_no_way() -> None:
    rng, ways = np.random.default_rng(4), MultipathDetector()
    behind = 6.0, 6.0, 9.0, 11.0, 14.0, 17.0, 20.0, 23.0
    for number in range(20):
        loud = [(20.0 + 5.0 * k, -40.0 + 11.0 * k, 26.0) for k in range(len(behind))]
        fainter = [(r + m, b, s - 12.0) for (r, b, s), m in zip(loud, behind, strict=True)]
        ping = make_ping(np.ones((2, 2000), np.uint8), t_ns=number * 150_000_000)
        bodies, others = (echo_table([echo(*each, rng) for each in rows]) for rows in (loud, fainter))
        assert not ways.of(ping, 0.0, bodies, others, 15.0)


def test_a_way_among_many_bodies_is_reported() -> None:
    rng = np.random.default_rng(4)
    field = [(float(rng.uniform(15, 90)), float(rng.uniform(-40, 40)), float(rng.uniform(20, 27))) for _ in range(10)]
    assert reported([6.0], field)[-1] == pytest.approx([6.0], abs=0.25)


def test_one_body_in_several_planes_is_no_way() -> None:
    planes = [(r + behind, b, s - behind * 10.0) for r, b, s in BODIES for behind in (0.0, 0.6, 0.8)]
    assert not any(reported([], planes))
