"""Track management: confirms objects and gives them ids, hibernates, activates and terminates them."""

from dataclasses import dataclass, field

import numpy as np

from ods.base.arrays import Indices, Ints, Mask
from ods.tracker.existence.lifecycle import ACTIVE, HIBERNATED, STAND_BY, TENTATIVE, TERMINATED
from ods.tracker.life.judgement import Judgement
from ods.tracker.map.hibernated import HibernatedObjects
from ods.tracker.map.map_object import MapObject
from ods.tracker.measurement.coverage.field_of_view import coverage_of, in_opening, near_coverage
from ods.tracker.measurement.scan import Scan, Vehicle
from ods.tracker.output.snapshot import Snapshot, map_objects, snapshot_of
from ods.tracker.prediction import ScanPrediction
from ods.tracker.restart.ids import PROVISIONAL_IDS, first_of
from ods.tracker.track import stitching
from ods.tracker.track.tracks import Tracks

WAKE_MARGIN_M = 5.0
"""Distance from the sector's edge at which hibernated objects become live; at twice that they are hibernated again."""


@dataclass(slots=True)
class Outcome:
    """Changes by a step beyond the snapshot."""

    taken: bool = True
    """False: the scan was older than the previous one and was ignored."""
    ended: Snapshot | None = None
    """Confirmed objects that were terminated, as they were last."""
    hibernated: list[MapObject] = field(default_factory=list)
    """Objects that belong in the map from now on, with their present data."""


class TrackManager:
    """Carries out changes of state, and keeps what outlives the live tracks: ids and the objects that sleep."""

    def __init__(self, known: list[MapObject], first_id: int, gate_sigmas: float) -> None:
        self.next_id = first_id
        self.asleep = HibernatedObjects(known)
        self._gate_sigmas = gate_sigmas

    def join(self, known: list[MapObject], first_id: int | None, tracks: Tracks) -> None:
        """See `Tracker.join`."""
        here = {*tracks.history.id.tolist(), *self.asleep.ids()}
        self.asleep.put([o for o in known if o.id not in here])
        if first_id is not None:
            self.next_id = first_of(first_id, self.next_id)

    def restore(self, known: list[MapObject], next_id: int, tracks: Tracks) -> None:
        """See `Tracker.restore`. Live objects that came from the map and are not `known` any more are dropped."""
        history = tracks.history
        live, found = set(history.id.tolist()), {o.id for o in known}
        self.asleep.put([o for o in known if o.id not in live])
        self.asleep.remember([o for o in known if o.id in live])
        lost = (history.state == HIBERNATED) & ~np.isin(history.id, list(found))
        if lost.any():
            tracks.keep(~lost)
        self.next_id = max([next_id, *(number + 1 for number in live | found if number < PROVISIONAL_IDS)])

    def wake(self, tracks: Tracks, scan: Scan, vehicle: Vehicle) -> None:
        """Let the hibernated objects in and near the sector join the live ones."""
        if not len(self.asleep):
            return
        ids, places = self.asleep.places(vehicle.position[:2], scan.sector.range_max_m + WAKE_MARGIN_M)
        if not len(ids):
            return
        inside = in_opening(np.ascontiguousarray(places), vehicle, coverage_of(scan.sector), WAKE_MARGIN_M)
        if inside.any():
            tracks.recall(self.asleep.wake(ids[inside].tolist()), scan.t_ns, vehicle.sigma_position[:2] ** 2)

    def manage(self, tracks: Tracks, judged: Judgement, prediction: ScanPrediction, utc_ns: int) -> Outcome:
        """Take the objects to their next states; return what that changes."""
        states, (lost, confirmed, for_the_map) = judged.states, judged.events.tolist()
        inside, history = prediction.field_of_view.inside, tracks.history
        before = history.state.copy()
        history.state[:] = states
        if lost:
            tracks.settle(((states == STAND_BY) & ~inside).nonzero()[0])
        continued = np.zeros(len(states), bool)
        if confirmed:
            continued = self._confirm(tracks, ((before == TENTATIVE) & (states == ACTIVE)).nonzero()[0])
        leaving, outcome = (states == TERMINATED) | continued, Outcome()
        if for_the_map:
            outcome, away = self._end_or_rest(tracks, before, ~continued, prediction, utc_ns)
            leaving |= away
        if leaving.any():
            tracks.keep(~leaving)
        return outcome

    def _end_or_rest(
        self, tracks: Tracks, before: Ints, own: Mask, prediction: ScanPrediction, utc_ns: int
    ) -> tuple[Outcome, Mask]:
        """End confirmed objects and put those that rest in the map, (n,) `own`: all that do not live on in another one.

        `before`: (n,) states before the image. Returns also which sleep from now on, (n,).
        """
        states, outcome, rested = tracks.history.state, Outcome(), before == HIBERNATED
        near = prediction.field_of_view.inside
        if rested.any():
            near = near_coverage(prediction.measurement, prediction.fan, 2.0 * WAKE_MARGIN_M)
        ended, resting = (states == TERMINATED) & (before != TENTATIVE) & own, (states == HIBERNATED) & own
        stored, away = resting & ~rested, resting & ~near
        tracks.rest(stored.nonzero()[0])
        if (ended | stored | away).any():
            outcome = self._report(tracks, ended, stored, utc_ns)
            self.asleep.sleep(tracks.history.id[away].tolist(), tracks.existence[away].tolist())
        return outcome, away

    def _confirm(self, tracks: Tracks, confirmed: Indices) -> Mask:
        """Give objects just confirmed their ids; return (n,) which old objects live on in one of them."""
        history, continued = tracks.history, np.zeros(len(tracks), bool)
        old = np.flatnonzero((history.state != TENTATIVE) & (history.state != TERMINATED))
        _, estimate = tracks.belief_and_moments()
        heirs, old = stitching.stitch(history, estimate, confirmed, old, self._gate_sigmas)
        tracks.inherit(heirs, old)
        continued[old] = True
        fresh = np.setdiff1d(confirmed, heirs)
        history.id[fresh] = np.arange(self.next_id, self.next_id + len(fresh))
        self.next_id += len(fresh)
        return continued

    def _report(self, tracks: Tracks, ended: Mask, stored: Mask, utc_ns: int) -> Outcome:
        """Return (n,) which tracks `ended` and (n,) which belong in the map."""
        reported = tracks.history.state != TENTATIVE
        now, outcome = snapshot_of(tracks), Outcome()
        if ended.any():
            outcome.ended = now.take(ended[reported])
            self.asleep.forget(outcome.ended.id.tolist())
        outcome.hibernated = map_objects(now.take(stored[reported]), utc_ns)
        self.asleep.remember(outcome.hibernated)
        return outcome
