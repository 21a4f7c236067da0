"""Splits the pose's error into noise, independent in every ping, and bias common to all pings.

A pose's standard deviation does not say which. Under water most of it is bias: dead reckoning is metres off, and the
places of consecutive pings still agree within millimetres. Taken for noise, it would open the gates by metres. The
noise is measured: if the vehicle keeps its motion, the place at a ping follows from the two before, and the variance of
the difference is that of the noise times 1 + (1 + r)^2 + r^2, r being the ratio of the two intervals.
"""

import numpy as np

from ods.compiled import native
from ods.tracker.measurement.scan import Vehicle
from ods.tracker.restart.state import PoseNoiseState

FORGETTING = 0.99
"""Of the weight of earlier pings at each."""
AT_LEAST_M = 0.3
"""Standard deviation, m, of the claim that always counts as noise: a bias of the attitude makes the positions seen from
a moving vehicle drift by that much, which more exact echoes would take for a height or a motion."""
UNSURE = 0.7
"""Half of the relative standard deviation of a variance measured so, times the root of the weight: consecutive
differences have two pings in common. By that share more of the claim counts as noise."""
PRIOR_PINGS = 3.0
"""Until more pings are compared, bias is taken to be the larger part, but of the tilt."""
GIVEN = FORGETTING, AT_LEAST_M, UNSURE, PRIOR_PINGS
LONGEST_STEP = 3.0
"""Number of former periods after which a pose counts as the first of a new sequence."""
COMPARED = 5
"""Quantities compared: north, east, yaw, and the vertical parts of ahead and of starboard."""


class PoseNoise:
    """The noise of north, east, yaw and tilt."""

    def __init__(self) -> None:
        self._known = np.zeros(1 + 3 * COMPARED)
        """Weight of what was compared, 0: no ping yet; sums of squares; what is compared of the last two pings."""
        self._times_ns: list[int] = []
        """Of those two."""

    def state(self) -> PoseNoiseState:
        """Return all that is known."""
        return PoseNoiseState(self._known.tolist(), self._times_ns.copy())

    def restore(self, state: PoseNoiseState) -> None:
        """Restore the state of another one. Raises ValueError for an invalid state."""
        known = np.array(state.known, np.float64)
        if known.shape != self._known.shape or not np.isfinite(known).all() or known[: 1 + COMPARED].min() < 0.0:
            raise ValueError("invalid checkpoint: pose noise must be five numbers")
        self._known, self._times_ns = known, state.times_ns[-2:]

    def take(self, vehicle: Vehicle, t_ns: int) -> Vehicle:
        """Take the pose of the next ping in; return the vehicle with its noise and its bias."""
        own = np.empty((2, 3))
        native.pose_noise(vehicle, self._step_to(t_ns), GIVEN, self._known, own)
        return vehicle._replace(noise=own[0], bias=own[1])

    def _step_to(self, t_ns: int) -> float:
        """Return the time since the last ping over that before it; 0: there is nothing to compare with."""
        if self._times_ns and t_ns <= self._times_ns[-1]:
            self._times_ns.clear()
        before, self._times_ns = self._times_ns, [*self._times_ns[-1:], t_ns]
        if len(before) < 2:
            return 0.0
        step = (t_ns - before[1]) / (before[1] - before[0])
        return step if step <= LONGEST_STEP else 0.0
