"""Beams that come one by one, put together to pieces of some that follow each other, each with its own time. Pure."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Bytes, Floats
from ods.base.clock import NS
from ods.messages import Sweep
from ods.sonar_link.ping360.messages import TURN, Beam

WIDEST = TURN // 12
"""Of a piece, gradians: 30 degrees."""
MOST_MISSING = 3
"""Beams between two that follow each other."""


class TimedBeam(NamedTuple):
    """One beam, and when its pulse left."""

    beam: Beam
    t_ns: int

    @property
    def angle(self) -> int:
        """Of the head, gradians from -200 to 199, to starboard."""
        return signed(self.beam.angle)

    @property
    def steps(self) -> int:
        """Gradians from beam to beam."""
        return self.beam.sweep.steps if self.beam.sweep else 1

    @property
    def span(self) -> tuple[int, int]:
        """The first and the last angle of the sector, to starboard, gradians; of a beam asked for by itself a turn."""
        sweep = self.beam.sweep
        width = (sweep.stop - sweep.start) % TURN if sweep else TURN
        if sweep is None or width + sweep.steps >= TURN:
            return -TURN // 2, TURN // 2 - self.steps
        first = signed(sweep.start)
        return first, first + width

    def alike(self, other: "TimedBeam") -> bool:
        """Return whether both were taken in the same way."""
        mine, others = self.beam._replace(angle=0, samples=b""), other.beam._replace(angle=0, samples=b"")
        return mine == others and len(self.beam.samples) == len(other.beam.samples)


class Piece(NamedTuple):
    """Beams that follow each other."""

    bearing_rad: Floats
    """(beams,) rising."""
    samples: Bytes
    """(beams, samples)."""
    t_ns: list[int]
    """(beams,) transmit times."""
    sweep: Sweep
    newest: TimedBeam


class Sector:
    """Collects beams; gives those of about `ping_s` away, fewer where the head turns back or jumps."""

    def __init__(self, ping_s: float) -> None:
        self._ping_ns = round(ping_s * NS)
        self._beams: list[TimedBeam] = []
        self._newest: TimedBeam | None = None
        self._direction = 0
        """Of the sweep under way: 1 to starboard, -1 to port, 0 not known yet."""
        self._gradian_s = 0.0
        """Time that the head takes for a gradian, by the newest piece of several beams."""

    @property
    def waits_since_ns(self) -> int | None:
        """When the newest beam that waits was sent; None: none does."""
        return self._beams[-1].t_ns if self._beams else None

    def take(self, beam: TimedBeam) -> list[Piece]:
        """Take the next beam; return the pieces that it completes."""
        found: list[Piece] = []
        if self._newest is not None and not self._goes_on(self._newest, beam):
            found += self.end()
        if self._newest is not None:
            self._direction = 1 if signed(beam.angle - self._newest.angle) > 0 else -1
            if abs(beam.angle - self._newest.angle) > TURN // 2:  # over the seam astern: bearings of a piece rise
                found += self._piece(ends=False)
        self._beams.append(beam)
        self._newest = beam
        if self._direction and self._at_end(beam):
            found += self.end()
        elif self._direction and self._is_enough(beam):
            found += self._piece(ends=False)
        return found

    def end(self) -> list[Piece]:
        """Give what there is: the sweep does not go on. What comes next begins another one."""
        found = self._piece(ends=True)
        self._newest, self._direction = None, 0
        return found

    def _goes_on(self, before: TimedBeam, beam: TimedBeam) -> bool:
        step = signed(beam.angle - before.angle)
        onward = step * self._direction > 0 or (step != 0 and not self._direction)
        return onward and before.alike(beam) and abs(step) <= (MOST_MISSING + 1) * beam.steps

    def _is_enough(self, newest: TimedBeam) -> bool:
        first = self._beams[0]
        return newest.t_ns - first.t_ns >= self._ping_ns or abs(signed(newest.angle - first.angle)) >= WIDEST

    def _at_end(self, newest: TimedBeam) -> bool:
        """Return whether the sector's last beam has come; a whole turn has none."""
        first, last = newest.span
        if last - first + newest.steps >= TURN:
            return False
        return (last - newest.angle if self._direction > 0 else newest.angle - first) < newest.steps

    def _piece(self, *, ends: bool) -> list[Piece]:
        beams, self._beams = self._beams, []
        if not beams:
            return []
        rising = self._direction >= 0
        ordered = beams if rising else beams[::-1]
        rows = np.frombuffer(b"".join(each.beam.samples for each in ordered), np.uint8).reshape(len(ordered), -1)
        bearing_rad = np.array([bearing_of(each.angle) for each in ordered])
        sweep = self._sweep(beams, rising=rising, ends=ends)
        return [Piece(bearing_rad, rows, [each.t_ns for each in ordered], sweep, beams[-1])]

    def _sweep(self, beams: list[TimedBeam], *, rising: bool, ends: bool) -> Sweep:
        newest = beams[-1]
        first, last = newest.span
        steps_done = sum(abs(signed(b.angle - a.angle)) for a, b in pairwise(beams))
        if steps_done:
            self._gradian_s = max((newest.t_ns - beams[0].t_ns) / NS / steps_done, 0.0)
        turn_s = self._gradian_s * (last - first + newest.steps)
        return Sweep(bearing_of(first), bearing_of(last), bearing_of(newest.steps), turn_s, rising, ends)


def bearing_of(angle: int) -> float:
    """Return gradians in rad; half a turn is no more than pi."""
    return angle / (TURN // 2) * math.pi


def signed(angle: int) -> int:
    """Return gradians from -200 to 199."""
    return (angle + TURN // 2) % TURN - TURN // 2
