"""The live objects: identity, state and existence beside the observer's filters, all kept in the same order."""

from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Ints, Mask
from ods.base.clock import NS
from ods.compiled import native
from ods.pose.utc import Restamp
from ods.tracker.existence import lifecycle
from ods.tracker.existence.evidence import ClutterStatistics, ExistenceTable
from ods.tracker.existence.model import MODEL
from ods.tracker.map.map_object import MapObject
from ods.tracker.measurement.model import PositionMeasurement
from ods.tracker.measurement.scan import Echoes, Scan
from ods.tracker.named import TrackTable, TrackTables
from ods.tracker.observer.belief import Belief, Estimate
from ods.tracker.observer.motion_hypotheses import StaticOrMovingObserver
from ods.tracker.restart.state import TracksState

MAP_CLUTTER_SHARE = 0.5
"""Share of clutter by which an object of the map is judged."""


class History(NamedTuple):
    """History of n objects: (n,) each."""

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


class Tracks:
    """Live objects, filtered together."""

    def __init__(self, observer: StaticOrMovingObserver) -> None:
        self.unjudged_s = 0.0
        """Time since existence was judged last."""
        self._observer = observer
        self._history = TrackTable(History, (len(History._fields),), np.int64)
        self._existence = TrackTable(ExistenceTable, (len(ExistenceTable._fields),))
        self.tables: list[TrackTable[Any]] = [self._history, self._existence, *observer.tables()]
        """All that is known of the objects: history, existence, and the observer's."""
        self._columns = TrackTables(self.tables)
        self._estimated: tuple[Belief, Estimate] | None = None

    def __len__(self) -> int:
        return len(self._history)

    @property
    def history(self) -> History:
        """Views: what is written to them stays."""
        return self._history.rows

    @property
    def judged(self) -> ExistenceTable:
        """Views."""
        return self._existence.rows

    @property
    def known(self) -> tuple[Ints, Floats]:
        """Tables of `History` and `ExistenceTable`, for kernels."""
        return self._history.table, self._existence.table

    @property
    def existence(self) -> Floats:
        """(n,) probability."""
        return self._existence.rows.visible + self._existence.rows.silent

    def belief_and_moments(self) -> tuple[Belief, Estimate]:
        """Return the hypotheses of all objects now, and their moments: computed once for each state of the filters."""
        if self._estimated is None:
            self._estimated = self._observer.belief_and_moments()
        return self._estimated

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (3, n) of all velocities."""
        return self._observer.velocity()

    def predict(self, since_ns: int, unobserved_ns: int) -> None:
        """Carry all objects on over `since_ns` >= 0; in so much of that they were not observed."""
        self._observer.predict(since_ns / NS)
        self.unjudged_s += since_ns / NS
        self._history.rows.unwatched[:] += unobserved_ns
        self._estimated = None

    def mark_unobserved(self, unobserved_ns: int, rows: Mask) -> None:
        """Record a time in which `rows` were not observed, so that they were not missed then."""
        self._history.rows.unwatched[rows] += unobserved_ns

    def restamp(self, moved: Restamp) -> None:
        """Follow a step of UTC."""
        history = self._history.rows
        for stamps in (history.first_utc, history.last_utc):
            stamps[(moved.since_ns <= stamps) & (stamps <= moved.until_ns)] += moved.step_ns

    def correct(self, rows: Indices, measured: PositionMeasurement, t_ns: int, utc_ns: int) -> None:
        """Correct the objects `rows`, each once, by one measurement each."""
        history = self._history.rows
        self._observer.reopen(rows[history.state[rows] >= lifecycle.STAND_BY])
        self._observer.update(rows, measured, (t_ns - history.last[rows]) / NS)
        native.tracks_seen(self._history.table, rows, t_ns, utc_ns)
        self._estimated = None

    def static(self) -> Floats:
        """Return (n,) the probability that each object does not move."""
        return self._observer.static()

    def judged_after_s(self) -> float:
        """Return the time since existence was judged last, as it is judged now."""
        since_s, self.unjudged_s = self.unjudged_s, 0.0
        return since_s

    def start(
        self,
        measured: PositionMeasurement,
        scan: Scan,
        echoes: Echoes,
        births: float,
        density: Floats,
        clutter: ClutterStatistics,
    ) -> None:
        """Append tentative objects, one an echo, given births a scan and (k,) false alarms a scan at each."""
        first = len(self)
        self._columns.extend(len(measured.radius))
        native.tracks_begin(self._history.table, first, scan.t_ns, scan.utc_ns)
        native.existence_begin(self._existence.table, first, births, density, echoes.table, clutter.values, MODEL)
        self._observer.start(measured)
        self._estimated = None

    def recall(self, objects: list[MapObject], t_ns: int, pose_variance: Floats) -> None:
        """Append hibernated objects of the map; `pose_variance`: (2,) of the vehicle's north and east now, m^2.

        Their places are by the pose of then, whose bias was another one.
        """
        variance = np.array([o.sigma for o in objects]).T.copy() ** 2
        variance[:2] += pose_variance[:, None]
        self._columns.extend(len(objects))
        new, exists = self._history.last(len(objects)), self._existence.last(len(objects))
        new.id[:], new.echoes[:] = [o.id for o in objects], [o.times_seen for o in objects]
        new.first_utc[:], new.last_utc[:] = zip(
            *((o.first_seen_utc_ns, o.last_seen_utc_ns) for o in objects), strict=True
        )
        new.state[:] = lifecycle.HIBERNATED
        new.born[:] = new.last[:] = t_ns
        new.unwatched[:] = 0
        exists.visible[:] = exists.first_visible[:] = [o.existence for o in objects]
        exists.nothing[:] = 1.0 - exists.visible
        exists.clutter_share[:] = MAP_CLUTTER_SHARE
        self._observer.recall(
            np.array([o.position for o in objects]).T.copy(),
            variance,
            np.array([o.covariance_ne for o in objects]),
            np.array([o.radius for o in objects]),
            np.array([o.sigma_radius for o in objects]) ** 2,
        )
        self._estimated = None

    def state(self) -> TracksState:
        """Return all that is known of the objects."""
        return TracksState(self.unjudged_s, [each.table.tobytes() for each in self.tables])

    def restore(self, state: TracksState) -> None:
        """Replace the objects by those of another `Tracks` with a like observer. Raises ValueError for other tables."""
        self._columns.restore(state.tables)
        self.unjudged_s, self._estimated = state.unjudged_s, None

    def settle(self, rows: Indices) -> None:
        """Decide for good whether each of `rows` moves, where that is established."""
        if len(rows):
            self._observer.settle(rows)
            self._estimated = None

    def rest(self, rows: Indices) -> None:
        """Decide for good that `rows` do not move."""
        if len(rows):
            self._observer.rest(rows)
            self._estimated = None

    def inherit(self, heirs: Indices, old: Indices) -> None:
        """Give `heirs` the identity and history of `old`: they are the same objects."""
        history = self._history.rows
        history.id[heirs] = history.id[old]
        history.first_utc[heirs] = history.first_utc[old]
        history.echoes[heirs] += history.echoes[old]
        self._observer.inherit(heirs, old)
        self._estimated = None

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""
        self._columns.keep(mask)
        self._estimated = None
