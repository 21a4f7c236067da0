"""What of the pose's error is noise, new with every ping, and what is a bias that all pings share.

A pose's standard deviation does not say which. Under water most of it is bias: dead reckoning is metres off, and the
places of consecutive pings still agree within millimetres. Taken for noise, it would open the gates by metres. The
noise is measured: if the vehicle keeps its motion, the place at a ping follows from the two before, and the variance of
the difference is that of the noise times 1 + (1 + r)^2 + r^2, r being the ratio of the two intervals.
"""

import math

import numpy as np

from ods.tracker.measurement.scan import Vehicle
from ods.tracker.state import PoseNoiseState

FORGETTING = 0.997
"""Of the weight of earlier pings at each."""
AT_LEAST_M = 0.3
"""So much of the claim always counts as noise: a bias of the attitude makes the places that a moving vehicle sees drift
by that much, which more exact echoes would take for a height or a motion."""
PRIOR_PINGS = 3.0
"""Until more pings are compared, bias is taken to be the larger part, but of the tilt."""
UNSURE = 1.39
"""Standard deviation of a variance measured so, over itself, times the root of the weight: differences of three pings
each, of which consecutive ones have two in common."""
LONGEST_STEP = 3.0
"""What comes later than so many of the periods before, or begins anew, is compared with nothing."""
NORTH, EAST, YAW, PITCHED, ROLLED = range(5)
"""What is compared; the last two are the vertical parts of ahead and of starboard."""


class PoseNoise:
    """The noise of north, east, yaw and tilt."""

    def __init__(self) -> None:
        self._squares, self._weight = [0.0] * 5, PRIOR_PINGS
        self._before: list[tuple[int, list[float]]] = []
        """Times, and what is compared, of the last two pings."""

    def state(self) -> PoseNoiseState:
        """Return all that is known."""
        return PoseNoiseState(self._weight, self._squares.copy(), self._before.copy())

    def restore(self, state: PoseNoiseState) -> None:
        """Go on where another one was. Raises ValueError when that makes no sense."""
        places = [number for _, place in state.before for number in place]
        numbers = [state.weight, *state.squares, *places]
        sizes = [len(state.squares), *(len(place) for _, place in state.before)]
        if set(sizes) != {5} or not all(map(math.isfinite, numbers)) or state.weight <= 0.0 or min(state.squares) < 0.0:
            raise ValueError("the noise of poses is not one of five numbers")
        self._squares, self._weight, self._before = state.squares.copy(), state.weight, state.before[-2:]

    def take(self, vehicle: Vehicle, t_ns: int) -> Vehicle:
        """Take the pose of the next ping in; return the vehicle with its noise and its bias."""
        north, east, _ = vehicle.position.tolist()
        (ahead_n, *_), (ahead_e, *_), (pitched, rolled, _) = vehicle.rotation.tolist()
        now = [north, east, math.atan2(ahead_e, ahead_n), pitched, rolled]
        claimed_n, claimed_e, _ = vehicle.sigma_position.tolist()
        roll, pitch, yaw = vehicle.sigma_attitude.tolist()
        if self._weight == PRIOR_PINGS:
            self._squares[PITCHED:] = [PRIOR_PINGS * claim * claim for claim in (pitch, roll)]
        if self._before and t_ns <= self._before[-1][0]:
            self._before.clear()
        self._compare(t_ns, now)
        self._before = [*self._before[-1:], (t_ns, now)]
        measured = [square / self._weight for square in self._squares]
        noise = [min(max(math.sqrt(m), AT_LEAST_M), c) for m, c in zip(measured, (claimed_n, claimed_e), strict=False)]
        most = 1.0 + UNSURE / math.sqrt(self._weight)
        claimed = claimed_n, claimed_e, yaw
        bias = [math.sqrt(max(0.0, c * c - most * m)) for c, m in zip(claimed, measured, strict=False)]
        tilt = math.sqrt(max(measured[PITCHED], measured[ROLLED]))
        return vehicle._replace(noise=np.array([*noise, tilt]), bias=np.array(bias))

    def _compare(self, t_ns: int, now: list[float]) -> None:
        if len(self._before) < 2:
            return
        (first_ns, first), (second_ns, second) = self._before
        step = (t_ns - second_ns) / (second_ns - first_ns)
        if step > LONGEST_STEP:
            return
        last, this = _change(first, second), _change(second, now)
        share = 1.0 / (1.0 + (1.0 + step) ** 2 + step**2)
        differs = (b - step * a for a, b in zip(last, this, strict=True))
        self._squares = [FORGETTING * s + share * d * d for s, d in zip(self._squares, differs, strict=True)]
        self._weight = FORGETTING * self._weight + 1.0


def _change(earlier: list[float], later: list[float]) -> tuple[float, float, float, float, float]:
    north, east, yaw, ahead, right = (b - a for a, b in zip(earlier, later, strict=True))
    return north, east, math.remainder(yaw, math.tau), ahead, right
