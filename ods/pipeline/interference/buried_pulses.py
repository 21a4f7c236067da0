"""Pulses that are buried in reverberation: only one a ping, or none, is loud enough to be an echo of its own.

Where another sonar's period is near our own or near a fraction of it, the loudest pulse of each ping stands on a line
over time, as a body's echo does. A body is alone; pulses come again one period later, at places that move with the
line. Each of these places is brighter with the pulse than one ping before or after, when it was elsewhere. By how much
is averaged over pings and places, and held against the same of all other places of the same beams: their spread is that
of speckle, noise and texture, whatever unit the samples have.
"""

from collections import deque
from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Floats
from ods.messages import Ping
from ods.pipeline.prepared.plan import sample_scale_of

PINGS, BEAMS = 8, 3
"""So many of the last pings are compared, in so many beams next to the direction."""
WIDTH_M = 0.4
"""Extent in range of what is compared: a pulse of 0.5 ms."""
import os
LEAD_M = float(os.environ.get('LEAD','0.1'))
MOST_A_PERIOD = 7
"""Pulses a period of what was found."""
FOUND, HEARD = 4.0, 2.0
"""Excess, in standard deviations, for pulses that are found, and for those that were and are still heard."""
MOST_OF_ONE = 5.0
"""The same that one place can show at most."""


class _Image(NamedTuple):
    """One ping."""

    ping: Ping
    frame: AnyArray
    sent_s: float
    s_a_m: float
    """Time of arrival a metre of range."""

    @property
    def geometry(self) -> tuple[object, ...]:
        """What pings must have in common to be compared."""
        return *self.frame.shape, self.ping.dr_m, self.ping.range0_m, self.s_a_m, self.ping.setting


class Train(NamedTuple):
    """Arrivals in one direction: `Train` of pulses.c."""

    period_s: float
    at_s: float
    """Of one of them."""
    bearing_rad: float
    heard_s: float
    buried: float
    arrivals: float


class BuriedPulses:
    """Compares the images of the last pings at the places where pulses would be."""

    def __init__(self) -> None:
        self._images: deque[_Image] = deque(maxlen=PINGS)

    def add(self, ping: Ping, frame: AnyArray, sent_s: float) -> None:
        """Take in the next ping; frame (beams, samples); sent_s: since a fixed instant."""
        image = _Image(ping, frame, sent_s, 2.0 / ping.sound_speed)
        if self._images and (self._images[-1].geometry != image.geometry or sent_s <= self._images[-1].sent_s):
            self._images.clear()
        self._images.append(image)

    def pulses_a_period(self, line: Train) -> int:
        """Return how many pulses come in the time from one arrival to the next; 1: no others are heard."""
        if len(self._images) < 2:
            return 1
        places = _Places(list(self._images), line)
        excess = {count: places.excess(line.period_s * np.arange(1, count) / count) for count in range(2, MOST_A_PERIOD + 1)}
        best = max(excess, key=excess.__getitem__)
        return best if excess[best] >= FOUND else 1

    def are_heard(self, train: Train) -> bool:
        """Return whether a train's pulses are still in the images."""
        return len(self._images) > 1 and _Places(list(self._images), train).excess(np.zeros(1)) >= HEARD


class _Places:
    """How bright the places of a train are beside the pings before and after, and how bright any others."""

    def __init__(self, images: list[_Image], train: Train) -> None:
        ping, rows = images[-1].ping, np.argsort(np.abs(np.array(images[-1].ping.bearing_rad) - train.bearing_rad))[:BEAMS]
        self._width = max(1, round(WIDTH_M / ping.dr_m))
        self._levels = np.array([_levels(image, rows, self._width) for image in images])
        self._images, self._train = images, train
        step_s = WIDTH_M * images[-1].s_a_m
        others = self._brighter(np.arange(step_s, train.period_s - step_s, step_s))
        others = others[np.isfinite(others)]
        self._mean, self._spread = (others.mean(), others.std()) if len(others) else (0.0, np.inf)

    def excess(self, later_s: Floats) -> float:
        """Return how much brighter those are that arrive so much later than the train, in standard deviations."""
        brighter = self._brighter(later_s)
        brighter = np.minimum((brighter[np.isfinite(brighter)] - self._mean) / max(self._spread, 1e-9), MOST_OF_ONE)
        return float(brighter.sum() / np.sqrt(len(brighter))) if len(brighter) else 0.0

    def _brighter(self, later_s: Floats) -> Floats:
        """Return by how much the log amplitude is higher than one ping before and after, (n,) mean of the pings."""
        total, count = np.zeros(len(later_s)), np.zeros(len(later_s))
        for one in range(len(self._images)):
            for other in (one - 1, one + 1):
                if 0 <= other < len(self._images):
                    self._compare(one, other, later_s, total, count)
        return np.where(count > 0, total / np.maximum(count, 1), np.nan)

    def _compare(self, one: int, other: int, later_s: Floats, total: Floats, count: Floats) -> None:
        image, period_s = self._images[one], self._train.period_s
        farthest_s = image.s_a_m * (image.ping.range0_m + image.ping.samples * image.ping.dr_m)
        first_s = np.mod(self._train.at_s + later_s - image.sent_s - LEAD_M * image.s_a_m, period_s)
        moved_s = np.mod(image.sent_s - self._images[other].sent_s, period_s)
        if min(moved_s, period_s - moved_s) < WIDTH_M * image.s_a_m:
            return
        for arrival_s in np.arange(0.0, farthest_s, period_s):
            column = np.rint(((first_s + arrival_s) / image.s_a_m - image.ping.range0_m) / image.ping.dr_m).astype(np.intp)
            inside = (column >= 0) & (column < self._levels.shape[1])
            column = column[inside]
            total[inside] += self._levels[one, column] - self._levels[other, column]
            count[inside] += 1


def _levels(image: _Image, rows: AnyArray, width: int) -> Floats:
    """Return the log amplitude of some beams together, mean of each column and the next ones, (samples - width + 1,)."""
    scale = sample_scale_of(image.ping)
    samples = image.frame[rows]
    amplitude = samples + 0.5 if scale.table is None else scale.table[samples]
    running = np.concatenate([[0.0], np.cumsum(amplitude.sum(axis=0, dtype=np.float64))])
    return np.log(np.maximum(running[width:] - running[:-width], 1e-9))
