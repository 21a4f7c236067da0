"""The live objects: identity, state and existence beside the observer's filters, all kept in the same order."""

from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Ints, Mask
from ods.base.clock import NS
from ods.tracker.association import wander
from ods.tracker.association.strength import Typical, evidence
from ods.tracker.map.map_object import MapObject
from ods.tracker.measurement.model import PositionMeasurement
from ods.tracker.named import TrackTable
from ods.tracker.observer.belief import Belief, Estimate, moment_match
from ods.tracker.observer.registry import Observer
from ods.tracker.state import TracksState
from ods.tracker.track import existence, lifecycle
from ods.tracker.utc import Restamp

FLICKERING = 0.03
"""A place flickers when its chance to show an echo without an object is above this."""


EVEN = 0.5
"""Share of spots that an object of the map, which is none, is judged by."""


class History(NamedTuple):
    """What became of n objects: (n,) each."""

    id: Ints
    """0 while tentative."""
    state: Ints
    """A state of `lifecycle`."""
    echoes: Ints
    """Times seen."""
    first_utc: Ints
    """UTC of the first echo, ns."""
    last_utc: Ints
    """UTC of the last echo, ns."""
    born: Ints
    """Ping time of the first echo (of waking, for objects of the map), ns."""
    last: Ints
    """Ping time of the last echo (of waking, for objects of the map), ns."""
    unwatched: Ints
    """Time since then in which no image was looked at where it is, ns."""


class Doubt(NamedTuple):
    """Whether n objects exist: (n,) probabilities, the first four as in `existence`."""

    visible: Floats
    silent: Floats
    nothing: Floats
    spot: Floats
    first_visible: Floats
    """That it existed after the first echo."""


class Unexplained(NamedTuple):
    """What is known of k echoes that no object explains: (k,) each."""

    clutter: Floats
    """False alarms a scan if it had as many everywhere as there,"""
    spots: Floats
    """and the share of spots among them: see `flicker`."""
    strength: Floats
    """dB; 0: not told."""
    typical: Typical
    """Of the echoes of nothing there."""


class Looks(NamedTuple):
    """How n objects were seen since they were started or recalled: (n,) each."""

    hits: Floats
    """Echoes after the first,"""
    looks: Floats
    """images in which there might have been one,"""
    flickers: Floats
    """and how many of these would have had one if there were no object: see `flicker`."""


class Nature(NamedTuple):
    """What tells n objects from the spots of a bottom, beside how often they are seen: (n,) each."""

    strength: Floats
    """Sum over their echoes of what they have over the echoes of nothing, in standard deviations of these,"""
    told: Floats
    """and number of the echoes that tell their strength;"""
    by_strength: Floats
    """the log-likelihood ratio taken of that, and"""
    by_motion: Floats
    """that of their motion;"""
    off_squares: Floats
    """sum of squares, m2, of how much their echoes were off their range,"""
    placed: Floats
    """number of those that tell it,"""
    by_wander: Floats
    """and the log-likelihood ratio taken of that;"""
    spots: Floats
    """the share of spots at their place that they are judged by."""


class Tracks:
    """Live objects, filtered together."""

    def __init__(self, observer: Observer) -> None:
        self.unjudged_s = 0.0
        """Time since existence was judged last."""
        self._observer = observer
        self._history = TrackTable(History, (len(History._fields),), np.int64)
        self._doubt = TrackTable(Doubt, (len(Doubt._fields),))
        self._looks = TrackTable(Looks, (len(Looks._fields),))
        self._nature = TrackTable(Nature, (len(Nature._fields),))
        self._told: tuple[Belief, Estimate] | None = None

    def __len__(self) -> int:
        return len(self._history)

    @property
    def history(self) -> History:
        """Views: what is written to them stays."""
        return self._history.rows

    @property
    def probabilities(self) -> Floats:
        """(4, n) of `existence`: visible, silent, nothing, spot."""
        first: Floats = self._doubt.table[: existence.EXISTENCE_STATES]
        return first

    @property
    def doubt(self) -> Doubt:
        """Views."""
        return self._doubt.rows

    @property
    def looks(self) -> Looks:
        """Views."""
        return self._looks.rows

    @property
    def nature(self) -> Nature:
        """Views."""
        return self._nature.rows

    @property
    def existence(self) -> Floats:
        """(n,) probability."""
        return self._doubt.rows.visible + self._doubt.rows.silent

    def told(self) -> tuple[Belief, Estimate]:
        """Return the hypotheses of all objects now, and their moments: computed once for each state of the filters."""
        if self._told is None:
            belief = self._observer.belief()
            self._told = belief, moment_match(belief)
        return self._told

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (3, n) of all velocities."""
        return self._observer.velocity()

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        self._observer.predict(dt)
        self.unjudged_s += dt
        self._told = None

    def look_away(self, unwatched_ns: int, rows: Mask | slice = slice(None)) -> None:
        """Take note that for so long no image showed `rows`: they were not missed in that time."""
        self._history.rows.unwatched[rows] += unwatched_ns

    def restamp(self, moved: Restamp) -> None:
        """Follow a step of UTC."""
        history = self._history.rows
        for stamps in (history.first_utc, history.last_utc):
            stamps[(moved.since_ns <= stamps) & (stamps <= moved.until_ns)] += moved.step_ns

    def correct(self, rows: Indices, measured: PositionMeasurement, t_ns: int, utc_ns: int) -> None:
        """Correct the objects `rows`, each once, by one measurement each."""
        history = self._history.rows
        since_s = (t_ns - history.last[rows]) / NS
        self._observer.reopen(rows[history.state[rows] >= lifecycle.STAND_BY])
        self._observer.update(rows, measured, since_s)
        history.echoes[rows] += 1
        history.last[rows] = t_ns
        history.unwatched[rows] = 0
        history.last_utc[rows] = utc_ns
        self._told = None

    def looked(self, hit: Mask, watched: Floats, flicker: Floats) -> None:
        """Take note of what an image showed: (n,) each, the last two as in `ScanMatch`."""
        seen, looks = self._looks.rows, np.maximum(hit, watched)
        seen.hits[:] += hit
        seen.looks[:] += looks
        seen.flickers[:] += flicker * looks

    def compare(self, strength: Floats, typical: Typical, spots: Floats, static_prior: float) -> None:
        """Judge existence by how strong the newest echoes are and by motion: (n,) each, as in `ScanMatch`.

        Confirmed objects are judged by what is known of their places by now.
        """
        nature = self._nature.rows
        self._take_strength(slice(None), strength, typical)
        by_motion = existence.evidence_of_motion(self.told()[1].static, static_prior)
        known = np.where(self.history.state == lifecycle.TENTATIVE, nature.spots, spots)
        change = by_motion - nature.by_motion - (logit(known) - logit(nature.spots))
        nature.by_motion[:], nature.spots[:] = by_motion, known
        self.probabilities[...] = existence.told_apart(self.probabilities, np.zeros(len(self)), change)

    def place(self, off_range: Floats, of_spots_m2: float) -> None:
        """Judge existence by how far the echoes wander: (n,) as in `ScanMatch`; mean square of spots, m2."""
        nature, told = self._nature.rows, np.isfinite(off_range)
        # the place is the mean of the echoes before, so the newest is off it by its own error and by that of the mean
        before = np.maximum(self.history.echoes - 1.0, 1.0)
        nature.off_squares[told] += (off_range**2 * before / (before + 1.0))[told]
        nature.placed[:] += told
        ratio = wander.evidence(nature.off_squares, nature.placed, of_spots_m2)
        change = np.where(told, ratio - nature.by_wander, 0.0)
        nature.by_wander[:] += change
        self.probabilities[...] = existence.told_apart(self.probabilities, np.zeros(len(self)), change)

    def _take_strength(self, rows: slice, strength: Floats, typical: Typical) -> None:
        nature, told = self._nature.rows, strength > 0.0
        nature.strength[rows] += np.where(told, (strength - typical.mean_db) / typical.sigma_db, 0.0)
        nature.told[rows] += told
        mean = nature.strength[rows] / np.maximum(nature.told[rows], 1.0)
        before = nature.by_strength[rows].copy()
        nature.by_strength[rows] = np.where(told, evidence(mean, nature.told[rows], typical), before)
        change = nature.by_strength[rows] - before
        self.probabilities[:, rows] = existence.told_apart(self.probabilities[:, rows], change, change)

    def intermittent(self, detection_probability: float) -> Mask:
        """Tell (n,) which are seen as places where echoes come and go are, and not as objects are there."""
        seen = self._looks.rows
        half_way = 0.5 * (detection_probability * seen.looks + seen.flickers)
        return (seen.flickers > FLICKERING * seen.looks) & (seen.hits < half_way)

    def start(self, measured: PositionMeasurement, t_ns: int, utc_ns: int, births: float, unknown: Unexplained) -> None:
        """Append tentative objects, one a measurement, given births a scan and what is known of these k echoes."""
        count = len(measured.radius)
        new, doubt = self._history.grow(count), self._doubt.grow(count)
        new.state[:], new.echoes[:] = lifecycle.TENTATIVE, 1
        new.first_utc[:] = new.last_utc[:] = utc_ns
        new.born[:] = new.last[:] = t_ns
        new.unwatched[:] = 0
        none = unknown.clutter / (births + unknown.clutter)
        doubt.visible[:] = 1.0 - none
        doubt.nothing[:], doubt.spot[:] = (1.0 - unknown.spots) * none, unknown.spots * none
        self._looks.grow(count)
        self._nature.grow(count).spots[:] = unknown.spots
        self._take_strength(slice(len(self) - count, None), unknown.strength, unknown.typical)
        doubt.first_visible[:] = doubt.visible
        self._observer.start(measured)
        self._told = None

    def recall(self, objects: list[MapObject], t_ns: int) -> None:
        """Append hibernated objects of the map."""
        new, doubt = self._history.grow(len(objects)), self._doubt.grow(len(objects))
        new.id[:], new.echoes[:] = [o.id for o in objects], [o.times_seen for o in objects]
        new.first_utc[:], new.last_utc[:] = zip(
            *((o.first_seen_utc_ns, o.last_seen_utc_ns) for o in objects), strict=True
        )
        new.state[:] = lifecycle.HIBERNATED
        new.born[:] = new.last[:] = t_ns
        new.unwatched[:] = 0
        doubt.visible[:] = doubt.first_visible[:] = [o.existence for o in objects]
        doubt.nothing[:] = 1.0 - doubt.visible
        self._looks.grow(len(objects))
        self._nature.grow(len(objects)).spots[:] = EVEN
        self._observer.recall(
            np.array([o.position for o in objects]).T,
            np.array([o.sigma for o in objects]).T ** 2,
            np.array([o.covariance_ne for o in objects]),
            np.array([o.radius for o in objects]),
            np.array([o.sigma_radius for o in objects]) ** 2,
        )
        self._told = None

    def state(self) -> TracksState:
        """Return all that is known of the objects."""
        return TracksState(self.unjudged_s, [each.table.tobytes() for each in self.tables()])

    def restore(self, state: TracksState) -> None:
        """Replace the objects by those of another `Tracks` with a like observer. Raises ValueError for other tables."""
        tables = self.tables()
        for table, stored in zip(tables, state.tables, strict=True):
            table.restore(stored)
        if len({len(table) for table in tables}) != 1:
            raise ValueError("tables of different lengths")
        self.unjudged_s, self._told = state.unjudged_s, None

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects: history, doubt, looks, nature, and the observer's."""
        return [self._history, self._doubt, self._looks, self._nature, *self._observer.tables()]

    def settle(self, rows: Indices) -> None:
        """Decide for good whether each of `rows` moves, where that is established."""
        if len(rows):
            self._observer.settle(rows)
            self._told = None

    def rest(self, rows: Indices) -> None:
        """Decide for good that `rows` do not move."""
        if len(rows):
            self._observer.rest(rows)
            self._told = None

    def inherit(self, heirs: Indices, old: Indices) -> None:
        """Give `heirs` the identity and history of `old`: they are the same objects."""
        history = self._history.rows
        history.id[heirs] = history.id[old]
        history.first_utc[heirs] = history.first_utc[old]
        history.echoes[heirs] += history.echoes[old]
        self._observer.inherit(heirs, old)
        self._told = None

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""
        self._history.keep(mask)
        self._doubt.keep(mask)
        self._looks.keep(mask)
        self._nature.keep(mask)
        self._observer.keep(mask)
        self._told = None


def logit(share: Floats) -> Floats:
    """Return the logarithms of the odds."""
    return np.asarray(np.log(share / (1.0 - share)))
