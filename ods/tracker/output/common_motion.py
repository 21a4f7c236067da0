"""Objects that all move alike: it is the vehicle's pose that moves, not they.

A heading that drifts turns all that is tracked about the vehicle; a place that drifts carries it along. Each object by
itself is a believable mover. Three or more that turn about the one place from which they are seen are none.
"""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats
from ods.tracker.existence.lifecycle import ACTIVE
from ods.tracker.output.snapshot import Snapshot

FEWEST = 3
"""Objects that move alike. Two may be movers by chance."""
FEWEST_BESIDE = 4
"""The same where there is another object, which does not: a mover, left out."""
SIGNIFICANT = 5.0
"""Standard deviations."""
EXPLAINED = 0.9
"""Share of the squared velocities, each over its variance, that the common motion must explain,"""
LEFT = 6.0
"""and the mean square of what it leaves, at most: three movers are explained to nine tenths by chance at times."""
LEAST_SIGMA_MPS = 0.02
"""A filter's velocity is never better known than that; keeps few objects from settling all."""
SLOWEST_TURN, SLOWEST_MPS = math.radians(0.2), 0.1
"""What is slower is within what an INS does."""
FASTEST_TURN = math.radians(0.5)
"""With a faster turn places are off by more than they claim, within seconds: the list is not valid."""


class CommonMotion(NamedTuple):
    """How all objects seem to move."""

    turn: float
    """About the vehicle, from north to east, rad/s,"""
    sigma_turn: float
    move: tuple[float, float]
    """and besides, north and east, m/s,"""
    sigma_move: float
    """in the direction that is known worst."""

    @property
    def turns(self) -> bool:
        """They do, beyond doubt."""
        return abs(self.turn) > max(SIGNIFICANT * self.sigma_turn, SLOWEST_TURN)

    @property
    def moves(self) -> bool:
        """Likewise."""
        return math.hypot(*self.move) > max(SIGNIFICANT * self.sigma_move, SLOWEST_MPS)

    def problem(self) -> str:
        """Say it in plain words, "" where it is nothing."""
        if self.turns:
            rate = f"{math.degrees(self.turn):.1f} +- {math.degrees(self.sigma_turn):.1f} deg/s"
            return f"objects at rest seem to turn by {rate} about the vehicle: does the heading drift?"
        if self.moves:
            speed = f"{math.hypot(*self.move):.2f} +- {self.sigma_move:.2f} m/s"
            return f"objects at rest seem to move by {speed}: does the INS's place drift?"
        return ""

    def reason(self) -> str:
        """Say why the list is not valid for it, "" where it is.

        Movers alike may be a convoy, or buoys in a current; none turns about us.
        """
        return self.problem() if self.turns and abs(self.turn) > FASTEST_TURN else ""


def common_motion(snapshot: Snapshot, centre: Floats) -> CommonMotion | None:
    """Return how the active objects seem to move about `centre`, (3,) NED; None where they do not move alike.

    Least squares, each velocity by its own standard deviation; one object may go its own way.
    """
    seen = snapshot.take(snapshot.state == ACTIVE)
    if len(seen) < FEWEST:
        return None
    found, left = _fitted(seen, centre)
    if found is None and len(seen) > FEWEST_BESIDE:
        found, _ = _fitted(seen.take(np.arange(len(seen)) != int(np.argmax(left))), centre)
    return found


def _fitted(seen: Snapshot, centre: Floats) -> tuple[CommonMotion | None, Floats]:
    """Return the motion, None where it does not explain the velocities, and (n,) the squares that it leaves of each."""
    north, east = seen.position[:2] - centre[:2, None]
    sigma = np.maximum(seen.sigma_velocity[:2], LEAST_SIGMA_MPS)
    one, zero = np.ones(len(seen)), np.zeros(len(seen))
    along = np.array([one, zero, -east]) / sigma[0], np.array([zero, one, north]) / sigma[1]
    design = np.concatenate(along, axis=1).T
    wanted = np.concatenate(seen.velocity[:2] / sigma)
    information = design.T @ design
    if not np.isfinite(information).all() or np.linalg.cond(information) > 1e12:
        return None, zero
    covariance = np.linalg.inv(information)
    motion = covariance @ (design.T @ wanted)
    left = ((wanted - design @ motion) ** 2).reshape(2, -1).sum(axis=0)
    rest, total = float(left.sum()), float(wanted @ wanted)
    if not rest <= min((1.0 - EXPLAINED) * total, LEFT * (wanted.size - motion.size)):  # nor for NaN
        return None, left
    turn, move, sigmas = float(motion[2]), (float(motion[0]), float(motion[1])), np.sqrt(np.diag(covariance))
    return CommonMotion(turn, float(sigmas[2]), move, float(sigmas[:2].max())), left
