"""Monitor of errors of pose, mounting and sound speed, seen in the common apparent motion of static objects.

Each object by itself is a believable mover. Several that turn about the one place from which they are seen, or that all
come nearer in proportion to their range, are none. The method is that of `ods calibrate`, on what is tracked.
"""

import math
from dataclasses import replace

import numpy as np

from ods.base.clock import NS
from ods.tracker.common_error.causes import DRIFT, FAST, SLOW, Finding, explanations, too_much
from ods.tracker.common_error.displaced import HELD_S, DisplacedObjects
from ods.tracker.common_error.least_squares import FAST_MEMORY_S, SLOW_MEMORY_S, FadingSums
from ods.tracker.common_error.sightings import Motion, design_of, sightings_of
from ods.tracker.existence.lifecycle import ACTIVE, STAND_BY
from ods.tracker.measurement.scan import Scan, Vehicle
from ods.tracker.output.snapshot import Snapshot

SEEN_EVERY_S, FITTED_EVERY_S = 0.1, 0.5
UNSTEADY = "sample spacing changes from ping to ping"
"""Says the pipeline; then ranges may be off by as much: by a metre or more, as a sound speed's noise is not."""


class CommonErrors:
    """Takes what a ping showed of the tracked objects."""

    def __init__(self) -> None:
        self.begin_again()

    def begin_again(self) -> None:
        """Reset, after a jump of the pose."""
        self._fast, self._slow = FadingSums(FAST_MEMORY_S), FadingSums(SLOW_MEMORY_S)
        self._displaced = DisplacedObjects()
        self._seen_s = self._fitted_s = self._found_s = -math.inf
        self._vehicle: tuple[Vehicle, Motion] | None = None
        self._before: list[Finding] = []
        self._findings: list[Finding] = []

    def look(self, snapshot: Snapshot, scan: Scan, motion: Motion) -> None:
        """Take in a ping: the objects after it, its echoes, and how the vehicle moves."""
        self._displaced.look(snapshot, scan, moving=bool(self._findings))
        t_s = scan.t_ns / NS
        if scan.vehicle is None or t_s - self._seen_s < SEEN_EVERY_S:
            return
        self._vehicle, self._seen_s = (scan.vehicle, motion), t_s
        seen = sightings_of(snapshot, scan, motion)
        self._fast.add(seen, t_s)
        # what moves may not seem to do so by an error that is larger where it is: only the vehicle changes the design
        away = self._slow.first_places(seen) - scan.vehicle.position[:2]
        self._slow.add(seen._replace(design=design_of(away, motion)), t_s)
        if t_s - self._fitted_s >= FITTED_EVERY_S:
            self._fitted_s = t_s
            self._explain(t_s)

    def _explain(self, t_s: float) -> None:
        """Find what is wrong; it is so when two fits in turn find it: while a drift begins, no cause fits."""
        found = self._found()
        before, self._before = self._before, found
        twice = [each for each in found if any(each.cause is other.cause for other in before)]
        if twice or t_s - self._found_s > HELD_S:
            self._findings, self._found_s = twice, t_s

    def _found(self) -> list[Finding]:
        """Return the errors that may be: what is too fast for the long memory before what is slow.

        But a drift may be an error of the yaw, which only the long memory can distinguish.
        """
        fast, slow = explanations(self._fast.reduced(), FAST), explanations(self._slow.reduced(), SLOW)
        return slow if slow and fast and fast[0].cause is DRIFT else fast or slow

    def forget(self, number: int) -> None:
        """Expect an object no more: an operator has dropped it."""
        self._displaced.forget(number)

    def problem(self) -> str:
        """Return the likely error, as text; "" if there is none."""
        return "; or ".join(map(str, self._findings))

    def reasons(self, *, convoy: bool = True, caution: str = "") -> list[str]:
        """Return why the list is not valid; convoy: what seems to drift may be one, as the poses make sense; caution:
        that of the ping."""
        unsteady = UNSTEADY in caution and not self._displaced.are_in_place
        found = too_much(self._findings, convoy) or self._displaced.reasons()
        return [*found, f"{caution}, and too few static objects show that ranges are right"] if unsteady else found

    def widened(self, snapshot: Snapshot) -> Snapshot:
        """Return live objects with what is known to be wrong with their places in their covariance."""
        if not self._findings or self._vehicle is None or not len(snapshot):
            return snapshot
        vehicle, motion = self._vehicle
        away = (snapshot.position[:2] - vehicle.position[:2, None]).T
        wrong = self._findings[0].offset(design_of(away, motion)).T
        wrong = wrong * np.isin(snapshot.state, (ACTIVE, STAND_BY))
        sigma = snapshot.sigma_position.copy()
        sigma[:2] = np.hypot(sigma[:2], wrong)
        return replace(snapshot, sigma_position=sigma, covariance_ne=snapshot.covariance_ne + wrong[0] * wrong[1])
