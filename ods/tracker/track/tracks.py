"""The table of live objects: identity, state, history and existence beside the observer's filters, column by column."""

import numpy as np

from ods.base.arrays import Floats, Indices, Ints, Mask
from ods.tracker.map.hibernated import MapObject
from ods.tracker.measurement.model import Fix
from ods.tracker.observer.belief import Estimate, mixture
from ods.tracker.observer.registry import Observer
from ods.tracker.observer.track_table import Columns
from ods.tracker.track import existence, lifecycle

ID, STATE, ECHOES, FIRST_UTC, LAST_UTC, BORN, LAST = range(7)
PROBABILITIES, FIRST_VISIBLE = slice(0, 3), 3


class Tracks:
    """Live objects, one column each; row names as above. The observer's columns are kept in the same order."""

    def __init__(self, observer: Observer) -> None:
        self.observer = observer
        self._ints = Columns(7, np.int64)
        self._floats = Columns(4, np.float64)

    def __len__(self) -> int:
        return len(self._ints)

    def _row(self, row: int) -> Ints:
        view: Ints = self._ints.data[row]
        return view

    @property
    def id(self) -> Ints:
        """(n,) 0 while tentative."""
        return self._row(ID)

    @property
    def state(self) -> Ints:
        """(n,) a state of `life`."""
        return self._row(STATE)

    @property
    def echoes(self) -> Ints:
        """(n,) times seen."""
        return self._row(ECHOES)

    @property
    def first_utc(self) -> Ints:
        """(n,) UTC of the first echo, ns."""
        return self._row(FIRST_UTC)

    @property
    def last_utc(self) -> Ints:
        """(n,) UTC of the last echo, ns."""
        return self._row(LAST_UTC)

    @property
    def born(self) -> Ints:
        """(n,) ping time of the first echo (of waking, for objects of the map), ns."""
        return self._row(BORN)

    @property
    def last(self) -> Ints:
        """(n,) ping time of the last echo (of waking, for objects of the map), ns."""
        return self._row(LAST)

    @property
    def probabilities(self) -> Floats:
        """(3, n) of `existence`: visible, silent, nothing."""
        view: Floats = self._floats.data[PROBABILITIES]
        return view

    @property
    def first_visible(self) -> Floats:
        """(n,) probability to exist after the first echo."""
        view: Floats = self._floats.data[FIRST_VISIBLE]
        return view

    @property
    def existence(self) -> Floats:
        """(n,) probability."""
        return np.asarray(1.0 - self.probabilities[existence.NOTHING])

    def estimate(self) -> Estimate:
        """Return mean and covariance of all objects now."""
        return mixture(self.observer.belief())

    def start(self, fix: Fix, t_ns: int, utc_ns: int, births: float, clutter: float) -> None:
        """Append tentative objects, one a fix."""
        count = len(fix.radius)
        ints = np.zeros((7, count), np.int64)
        ints[STATE], ints[ECHOES] = lifecycle.TENTATIVE, 1
        ints[FIRST_UTC] = ints[LAST_UTC] = utc_ns
        ints[BORN] = ints[LAST] = t_ns
        floats = np.empty((4, count))
        floats[PROBABILITIES] = existence.start(count, births, clutter)
        floats[FIRST_VISIBLE] = floats[existence.VISIBLE]
        self._ints.append(ints)
        self._floats.append(floats)
        self.observer.start(fix)

    def recall(self, objects: list[MapObject], t_ns: int) -> None:
        """Append hibernated objects of the map."""
        rows = [
            (o.id, lifecycle.HIBERNATED, o.times_seen, o.first_seen_utc_ns, o.last_seen_utc_ns, t_ns, t_ns)
            for o in objects
        ]
        floats = np.empty((4, len(objects)))
        floats[PROBABILITIES] = existence.established(np.array([o.existence for o in objects]))
        floats[FIRST_VISIBLE] = floats[existence.VISIBLE]
        self._ints.append(np.array(rows, np.int64).T)
        self._floats.append(floats)
        self.observer.recall(
            np.array([o.position for o in objects]).T,
            np.array([o.sigma for o in objects]).T ** 2,
            np.array([o.covariance_ne for o in objects]),
            np.array([o.radius for o in objects]),
            np.array([o.sigma_radius for o in objects]) ** 2,
        )

    def seen(self, rows: Indices, t_ns: int, utc_ns: int) -> None:
        """Count an echo of each of `rows`."""
        ints = self._ints.data
        ints[ECHOES, rows] += 1
        ints[LAST, rows] = t_ns
        ints[LAST_UTC, rows] = utc_ns

    def inherit(self, heirs: Indices, old: Indices) -> None:
        """Give `heirs` the identity and history of `old`: they are the same objects."""
        ints = self._ints.data
        ints[ID, heirs] = ints[ID, old]
        ints[FIRST_UTC, heirs] = ints[FIRST_UTC, old]
        ints[ECHOES, heirs] += ints[ECHOES, old]
        self.observer.inherit(heirs, old)

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""
        self._ints.keep(mask)
        self._floats.keep(mask)
        self.observer.keep(mask)
