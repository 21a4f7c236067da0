"""Beams to pieces of a sweep: none lost, each with its own time, bearings rising, whichever way the head turns."""

import math

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.base.clock import MS, NS
from ods.sonar_link.ping360.messages import Beam, Sweep
from ods.sonar_link.ping360.sector import Piece, Sector, TimedBeam

GRADIAN = math.pi / 200.0
EVERY_NS = 80 * MS
SWEEP = Sweep(380, 20, 1)


def beam(angle: int, number: int, sweep: Sweep | None = SWEEP, *, gain: int = 1) -> TimedBeam:
    return TimedBeam(Beam(gain, angle % 400, 100, 1600, 750, sweep, bytes([number % 256] * 10)), number * EVERY_NS)


def pieces_of(angles: list[int], sweep: Sweep | None = SWEEP) -> list[Piece]:
    sector = Sector(0.8)
    found = [piece for number, angle in enumerate(angles) for piece in sector.take(beam(angle, number, sweep))]
    return found + sector.end()


def test_a_sector_to_and_fro() -> None:
    there, back = list(range(-20, 21)), list(range(20, -21, -1))
    found = pieces_of(there + back + [-20])
    assert min(len(piece.t_ns) for piece in found) == 1
    first = found[0]
    assert first.bearing_rad == pytest.approx(np.arange(-20, -9) * GRADIAN)
    assert first.t_ns == [number * EVERY_NS for number in range(11)]
    assert first.samples[:, 0].tolist() == list(range(11))
    assert (first.sweep.bearing_min_rad, first.sweep.bearing_max_rad) == pytest.approx((-20 * GRADIAN, 20 * GRADIAN))
    assert first.sweep.turn_s == pytest.approx(41 * 0.08)
    assert {round(piece.sweep.turn_s, 3) for piece in found} == {3.28}  # of a lone beam that is left, too
    ends = [piece for piece in found if piece.sweep.ends]
    assert [math.degrees(piece.newest.angle * GRADIAN) for piece in ends] == pytest.approx([18.0, -18.0, -18.0])
    backwards = found[-2]
    assert not backwards.sweep.rising
    assert np.all(np.diff(backwards.bearing_rad) > 0.0)
    assert backwards.t_ns == sorted(backwards.t_ns, reverse=True)


@given(st.integers(1, 10), st.integers(5, 180), st.integers(1, 4), st.booleans())
def test_no_beam_is_lost_or_reported_twice(steps: int, half: int, sweeps: int, rising: bool) -> None:
    half -= half % steps
    there = list(range(-half, half + 1, steps))
    angles = [angle for turn in range(sweeps) for angle in (there if rising ^ (turn % 2 == 1) else there[::-1])]
    found = pieces_of(angles, Sweep((400 - half) % 400, half, steps))
    reported = sorted(
        (t_ns, bearing) for piece in found for t_ns, bearing in zip(piece.t_ns, piece.bearing_rad, strict=True)
    )
    assert [t_ns for t_ns, _ in reported] == [number * EVERY_NS for number in range(len(angles))]
    assert [bearing for _, bearing in reported] == pytest.approx([angle * GRADIAN for angle in angles])
    assert all(np.all(np.diff(piece.bearing_rad) > 0.0) for piece in found)


def test_a_turn_goes_over_the_seam_astern_and_never_ends() -> None:
    found = pieces_of([angle % 400 for angle in range(150, 450)], Sweep(200, 199, 1))
    assert not any(piece.sweep.ends for piece in found[:-1])
    assert all(np.all(np.diff(piece.bearing_rad) > 0.0) for piece in found)
    assert sum(len(piece.t_ns) for piece in found) == 300
    assert found[1].sweep.bearing_max_rad - found[1].sweep.bearing_min_rad == pytest.approx(399 * GRADIAN)


@pytest.mark.parametrize("other", [beam(5, 1, gain=2), beam(5, 1, None), beam(-30, 1), beam(4, 1)])
def test_a_beam_that_does_not_go_on_ends_the_sweep(other: TimedBeam) -> None:
    sector = Sector(0.8)
    assert sector.take(beam(4, 0)) == []
    (piece,) = sector.take(other)
    assert piece.sweep.ends
    assert len(piece.t_ns) == 1


def test_beams_that_are_lost_on_the_way_cut_nothing() -> None:
    sector = Sector(60.0)
    assert not [piece for at in (0, 1, 4, 5) for piece in sector.take(beam(at, at))]
    (piece,) = sector.end()
    assert piece.bearing_rad == pytest.approx(np.array([0, 1, 4, 5]) * GRADIAN)
    assert piece.t_ns[-1] == 5 * EVERY_NS < NS
