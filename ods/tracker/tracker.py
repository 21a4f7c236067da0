"""Detections and pose to tracked objects: one `step` a ping, for all objects at once [SSIE figure 5]."""

import numpy as np

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.pose.utc import Restamp
from ods.tracker.association.hypotheses.clutter import Clutter
from ods.tracker.association.match import match_scan
from ods.tracker.association.registry import association_of
from ods.tracker.existence import lifecycle
from ods.tracker.existence.evidence import ClutterStatistics, Coherence
from ods.tracker.life.judgement import judge
from ods.tracker.life.management import Outcome, TrackManager
from ods.tracker.map.map_object import MapObject
from ods.tracker.measurement.pose.pose_noise import PoseNoise
from ods.tracker.measurement.scan import Scan
from ods.tracker.observer.registry import make_observer
from ods.tracker.output.snapshot import Snapshot, map_objects, snapshot_of, snapshot_of_map
from ods.tracker.prediction import predict_scan
from ods.tracker.restart.state import MapChanges, TrackerState
from ods.tracker.settings import PLUGINS, STATIC, TrackerSettings
from ods.tracker.track.plausibility import validate_tracks
from ods.tracker.track.tracks import Tracks

FIRST_SCANS = 2
"""Number of scans after the start in which all objects are new: one may be missed in the very first."""
BIRTHS_PERIOD_S = 0.15
"""Time since the scan before for which `births_per_scan` holds."""


class Tracker:
    """The state of the tracker between pings. No I/O, no clock, no randomness."""

    def __init__(self, settings: TrackerSettings, known: list[MapObject] | None = None, first_id: int = 1) -> None:
        """Start with the hibernated objects `known`; new ids count up from `first_id`. Raises PluginError."""
        PLUGINS.load(settings.plugins)
        self.settings = settings
        self._tracks = Tracks(make_observer(settings.observer, settings.motion))
        self._associate = association_of(settings.association)
        self._clutter, self._clutter_statistics = Clutter(settings.echo.clutter_per_scan), ClutterStatistics()
        self._manager = TrackManager(known or [], first_id, settings.echo.gate_sigmas)
        self._pose_noise = PoseNoise()
        self._coherence = Coherence()
        self._t_ns: int | None = None
        self._scans = 0

    @property
    def t_ns(self) -> int | None:
        """Time of the newest scan; None before the first."""
        return self._t_ns

    @property
    def next_id(self) -> int:
        """The id that the next new object gets."""
        return self._manager.next_id

    def join(self, known: list[MapObject], first_id: int | None) -> None:
        """Take in those of the hibernated objects `known` that are not here yet; new ids are `first_id` or more."""
        self._manager.join(known, first_id, self._tracks)

    def state(self) -> TrackerState:
        """Return all that is known but the objects of the map (`map_changes`)."""
        counted = self._clutter.state(), self._clutter_statistics.save()
        return TrackerState(self._t_ns, self._scans, self._tracks.state(), *counted, self._pose_noise.state())

    def map_changes(self) -> MapChanges:
        """Return how the objects that belong in the map differ from those at the last `whole_map`."""
        return self._manager.asleep.changes()

    def whole_map(self) -> list[MapObject]:
        """Return all objects that belong in the map, those awake too."""
        return self._manager.asleep.whole()

    def restore(self, state: TrackerState, known: list[MapObject], next_id: int) -> None:
        """Restore the state of another tracker with the same settings; `known`: its objects that belong in the map.

        Raises ValueError for an invalid state; this tracker is unusable then.
        """
        self._t_ns, self._scans = state.t_ns, state.scans
        self._tracks.restore(state.tracks)
        validate_tracks(self._tracks, state.t_ns or 0)
        self._clutter.restore(state.clutter)
        self._clutter_statistics.load(state.clutter_statistics)
        self._pose_noise.restore(state.pose_noise)
        self._manager.restore(known, next_id, self._tracks)

    def step(self, scan: Scan) -> Outcome:
        """Take one ping in. Pings must come in order of time: an older one is left out."""
        if self._t_ns is not None and scan.t_ns < self._t_ns:
            return Outcome(taken=False)
        tracks, settings, vehicle = self._tracks, self.settings, scan.vehicle
        since_ns = 0 if self._t_ns is None else scan.t_ns - self._t_ns
        between_ns = since_ns * scan.skipped_pings // (scan.skipped_pings + 1)
        self._t_ns = scan.t_ns
        if vehicle is None or not scan.usable:
            tracks.predict(since_ns, since_ns)
            return Outcome()
        tracks.predict(since_ns, between_ns)
        self._scans += 1
        births = self._births(since_ns / NS)
        vehicle = self._pose_noise.take(vehicle, scan.t_ns)
        self._manager.wake(tracks, scan, vehicle)
        prediction = predict_scan(tracks, scan, vehicle, settings)
        tracks.mark_unobserved(since_ns // (scan.skipped_pings + 1), prediction.field_of_view.unseen)
        match = match_scan(scan, prediction, self._clutter, self._associate, settings.echo)
        tracks.correct(match.objects, match.measurement, scan.t_ns, scan.utc_ns)
        judged = judge(tracks, prediction, match, self._clutter_statistics, self._coherence, scan, settings)
        outcome = self._manager.manage(tracks, judged, prediction, scan.utc_ns)
        if match.unexplained is not None:
            tracks.start(match.unexplained, scan, match.rest, births, match.density, self._clutter_statistics)
        return outcome

    def _births(self, since_s: float) -> float:
        """Return the number of new objects that is expected in a scan, so long after the one before."""
        echo = self.settings.echo
        if self._scans <= FIRST_SCANS:
            return echo.births_at_start
        # two scans of one instant are of different sonars, or of different planes
        return echo.births_per_scan * (since_s or BIRTHS_PERIOD_S) / BIRTHS_PERIOD_S

    def begin_again(self) -> Snapshot:
        """Drop all live objects, as they are not at their reported positions; return the confirmed ones that are gone.

        Objects of the map sleep again as they were, and the next image is as the first.
        """
        self._manager.asleep.sleep_all()
        live = snapshot_of(self._tracks)
        dropped = live.take(~np.isin(live.id, list(self._manager.asleep.ids())))
        self._tracks.keep(np.zeros(len(self._tracks), np.bool_))
        self._scans = 0
        return dropped

    def forget(self, wanted: int) -> Snapshot | None:
        """Drop a confirmed object, and from the map, too; return it as it was, None: there is none with this id.

        Echoes of it begin a new one.
        """
        known = self.snapshot()
        found = known.take(known.id == wanted)
        if not len(found):
            return None
        history = self._tracks.history
        self._tracks.keep((history.id != wanted) | (history.state == lifecycle.TENTATIVE))
        self._manager.asleep.forget([wanted])
        return found

    def snapshot(self, within: tuple[Floats, float] | None = None) -> Snapshot:
        """Return all confirmed objects at the newest scan.

        `within`: position (3,) of the vehicle and the distance up to which sleeping objects are included; by default
        all of them.
        """
        live, sleepers = snapshot_of(self._tracks), self._manager.asleep
        asleep = sleepers.all() if within is None else sleepers.near(within[0][:2], within[1])
        return live.joined(snapshot_of_map(asleep)) if asleep else live

    def restamp(self, moved: Restamp) -> list[MapObject]:
        """Follow a step of UTC; return the changes for the map."""
        self._tracks.restamp(moved)
        return self._manager.asleep.restamp(moved)

    def resting(self, utc_ns: int) -> list[MapObject]:
        """Return the live confirmed objects that do not move, as objects of the map: for the end of the mission."""
        live = snapshot_of(self._tracks)
        return map_objects(live.take((live.static >= STATIC) & (live.state != lifecycle.HIBERNATED)), utc_ns)
