"""Detections and pose to tracked objects: one `step` a ping, for all objects at once.

A step carries the objects on to the ping, compares the image with what the sonar should see of them, corrects their
states with the echoes given to them, judges whether they exist, and leads each through its life [SSIE figure 5].
"""

import math
from dataclasses import dataclass, field

import msgspec
import numpy as np

from ods.base.arrays import Floats, Indices, Ints, Mask
from ods.base.clock import NS
from ods.base.kernel import kernel
from ods.tracker.association.clutter import Clutter
from ods.tracker.association.match import WAKE_MARGIN_M, Look, look
from ods.tracker.association.registry import association_of
from ods.tracker.map.hibernated import Archive, MapObject
from ods.tracker.measurement import model
from ods.tracker.measurement.scan import Scan, Vehicle
from ods.tracker.observer.belief import Estimate, mixture
from ods.tracker.observer.registry import make_observer
from ods.tracker.output.snapshot import Picture, map_objects, picture_of, picture_of_map
from ods.tracker.settings import TrackerSettings
from ods.tracker.track import existence, lifecycle, stitching
from ods.tracker.track.tracks import Tracks

FIRST_LOOKS = 2
"""In so many images after the start all objects are new: one that is there may be missed in the very first."""


@dataclass(slots=True)
class Outcome:
    """What a step changed beyond the picture."""

    taken: bool = True
    """False: the scan was older than the one before and was left out."""
    ended: Picture | None = None
    """Confirmed objects that were terminated, as they were last."""
    hibernated: list[MapObject] = field(default_factory=list)
    """Objects that belong in the map from now on, with their present data."""


class Tracker:
    """The state of the tracker between pings. No I/O, no clock, no randomness."""

    def __init__(self, settings: TrackerSettings, known: list[MapObject] | None = None, first_id: int = 1) -> None:
        """Start with the hibernated objects `known`; new ids count up from `first_id`.

        Raises ValueError when the settings name an observer or an association that there is not.
        """
        self.settings = settings
        self.next_id = first_id
        self._tracks = Tracks(make_observer(settings.observer, settings.motion))
        self._associate = association_of(settings.association)
        self._archive = Archive(known or [])
        self._awake: dict[int, MapObject] = {}
        self._clutter = Clutter(settings.echo.clutter_per_scan)
        self._t_ns: int | None = None
        self._since_judged = 0.0
        self._looks = 0

    @property
    def t_ns(self) -> int | None:
        """Time of the newest scan; None before the first."""
        return self._t_ns

    def step(self, scan: Scan) -> Outcome:
        """Take one ping in. Pings must come in order of time: an older one is left out."""
        if self._t_ns is not None and scan.t_ns < self._t_ns:
            return Outcome(taken=False)
        self._advance(scan.t_ns)
        outcome = Outcome()
        if scan.vehicle is None or not scan.usable:
            return outcome
        self._looks += 1
        self._wake(scan, scan.vehicle)
        belief = self._tracks.observer.belief()
        estimate = mixture(belief)
        clutter = self._clutter.density(scan.echoes, scan.sector)
        visibility = existence.visibility(self._tracks.probabilities, self._since_judged, self.settings.echo)
        unseen_s = (scan.t_ns - self._tracks.last) / NS
        state = self._tracks.state
        seen = look(
            scan, scan.vehicle, belief, estimate, state, unseen_s, visibility, clutter, self.settings, self._associate
        )
        if len(self._tracks):
            self._clutter.count(scan.echoes.take(seen.new), scan.sector, scan.looked)
        self._correct(seen, scan)
        after = self._judge(seen, estimate, scan.t_ns)
        self._change(after, seen, scan, outcome)
        self._start(seen, scan, scan.vehicle)
        return outcome

    def picture(self, within: tuple[Floats, float] | None = None) -> Picture:
        """Return all confirmed objects at the newest scan.

        `within`: position (3,) of the vehicle and the distance up to which sleeping objects are included; by default
        all of them.
        """
        live = picture_of(self._tracks, self._tracks.estimate())
        asleep = self._archive.all() if within is None else self._archive.near(within[0][:2], within[1])
        return live.joined(picture_of_map(asleep)) if asleep else live

    def resting(self, utc_ns: int) -> list[MapObject]:
        """Return the live confirmed objects that do not move, as objects of the map: for the end of the mission."""
        estimate = self._tracks.estimate()
        live = picture_of(self._tracks, estimate)
        static = estimate.static[self._tracks.state != lifecycle.TENTATIVE] >= lifecycle.STATIC
        return map_objects(live.take(static & (live.state != lifecycle.HIBERNATED)), utc_ns)

    def _advance(self, t_ns: int) -> None:
        dt = 0.0 if self._t_ns is None else (t_ns - self._t_ns) / NS
        self._t_ns = t_ns
        self._tracks.observer.predict(dt)
        self._since_judged += dt

    def _wake(self, scan: Scan, vehicle: Vehicle) -> None:
        """Let the hibernated objects in and near the sector join the live ones."""
        sector = scan.sector
        ids, places = self._archive.places(vehicle.position[:2], sector.range_max_m + WAKE_MARGIN_M)
        if not len(ids):
            return
        edges = sector.bearing_min_rad, sector.bearing_max_rad
        inside = _in_opening(np.ascontiguousarray(places), vehicle, *edges, WAKE_MARGIN_M)
        if inside.any():
            woken = self._archive.remove(ids[inside].tolist())
            self._awake |= {o.id: o for o in woken}
            self._tracks.recall(woken, scan.t_ns)

    def _correct(self, seen: Look, scan: Scan) -> None:
        """Correct the states of the objects seen."""
        tracks, rows = self._tracks, seen.objects
        since_s = (scan.t_ns - tracks.last[rows]) / NS
        tracks.observer.reopen(rows[tracks.state[rows] >= lifecycle.STAND_BY])
        tracks.observer.update(rows, seen.fix, since_s)
        tracks.seen(rows, scan.t_ns, scan.utc_ns)

    def _judge(self, seen: Look, estimate: Estimate, t_ns: int) -> Ints:
        """Judge existence by the image; return each object's next state."""
        tracks, settings = self._tracks, self.settings
        tentative = tracks.state == lifecycle.TENTATIVE
        probabilities = tracks.probabilities
        carried = existence.carry_on(probabilities, tracks.echoes, seen.watched, self._since_judged, settings.echo)
        probabilities[...] = existence.judge(carried, seen.hit, seen.evidence, seen.expected)
        self._since_judged = 0.0
        evidence = lifecycle.Evidence(
            hit=seen.hit,
            inside=seen.inside,
            skipped=seen.skipped,
            echoes=tracks.echoes,
            unseen_s=(t_ns - tracks.last) / NS,
            existence=tracks.existence,
            visible=probabilities[existence.VISIBLE],
            first_visible=tracks.first_visible,
            static=estimate.static >= lifecycle.REST,
            covered=stitching.covered(
                estimate, tracks.state == lifecycle.STAND_BY, seen.hit & (tracks.state == lifecycle.ACTIVE)
            ),
            stray=stitching.strays(tracks, estimate, tentative & seen.hit, ~tentative & ~seen.hit),
            sigma=np.sqrt(np.maximum(estimate.variance[0], estimate.variance[1])),
        )
        return lifecycle.next_states(tracks.state, evidence, settings.life)

    def _change(self, after: Ints, seen: Look, scan: Scan, outcome: Outcome) -> None:
        """Carry out the changes of state."""
        tracks = self._tracks
        before = tracks.state.copy()
        tracks.state[:] = after
        tracks.observer.settle(((after == lifecycle.STAND_BY) & ~seen.inside).nonzero()[0])
        if (after == before).all() and not (after == lifecycle.HIBERNATED).any():
            return
        joined = self._name(((before == lifecycle.TENTATIVE) & (after == lifecycle.ACTIVE)).nonzero()[0])
        ended = (after == lifecycle.TERMINATED) & (before != lifecycle.TENTATIVE) & ~joined
        stored = (after == lifecycle.HIBERNATED) & (before != lifecycle.HIBERNATED) & ~joined
        asleep = (after == lifecycle.HIBERNATED) & ~seen.near & ~joined
        tracks.observer.rest(stored.nonzero()[0])
        if (ended | stored | asleep).any():
            self._report(ended, stored, asleep, scan.utc_ns, outcome)
        leaving = (after == lifecycle.TERMINATED) | joined | asleep
        if leaving.any():
            tracks.keep(~leaving)

    def _name(self, confirmed: Indices) -> Mask:
        """Give objects just confirmed their ids; return (n,) which old objects live on in one of them."""
        tracks = self._tracks
        joined = np.zeros(len(tracks), bool)
        if not len(confirmed):
            return joined
        silent = np.flatnonzero((tracks.state != lifecycle.TENTATIVE) & (tracks.state != lifecycle.TERMINATED))
        young, old = stitching.successors(tracks, tracks.estimate(), confirmed, silent, self.settings.echo.gate_sigmas)
        tracks.inherit(young, old)
        joined[old] = True
        fresh = np.setdiff1d(confirmed, young)
        tracks.id[fresh] = np.arange(self.next_id, self.next_id + len(fresh))
        self.next_id += len(fresh)
        return joined

    def _report(self, ended: Mask, stored: Mask, asleep: Mask, utc_ns: int, outcome: Outcome) -> None:
        """Put into the outcome what ended and what belongs in the map, and into the archive what sleeps."""
        tracks = self._tracks
        reported = tracks.state != lifecycle.TENTATIVE
        picture = picture_of(tracks, tracks.estimate())
        if ended.any():
            outcome.ended = picture.take(ended[reported])
            for object_id in outcome.ended.id.tolist():
                self._awake.pop(object_id, None)
        outcome.hibernated = map_objects(picture.take(stored[reported]), utc_ns)
        self._awake |= {o.id: o for o in outcome.hibernated}
        existences = tracks.existence[asleep].tolist()
        self._archive.put(
            [
                msgspec.structs.replace(self._awake.pop(object_id), existence=probability)
                for object_id, probability in zip(tracks.id[asleep].tolist(), existences, strict=True)
            ]
        )

    def _start(self, seen: Look, scan: Scan, vehicle: Vehicle) -> None:
        """Start a tentative object from each echo that belongs to none."""
        if len(seen.new):
            fix = model.fix(scan.echoes.take(seen.new), vehicle, scan.sector.half_vertical_rad)
            echo = self.settings.echo
            births = echo.births_at_start if self._looks <= FIRST_LOOKS else echo.births_per_scan
            self._tracks.start(fix, scan.t_ns, scan.utc_ns, births, self._clutter.per_scan)


@kernel
def _in_opening(places: Floats, vehicle: Vehicle, port: float, starboard: float, margin_m: float) -> Mask:
    """Tell which of the (2, k) north-east places are between two bearings, or not farther off than `margin_m`."""
    inside = np.empty(places.shape[1], np.bool_)
    for i in range(len(inside)):
        north, east = places[0, i] - vehicle.position[0], places[1, i] - vehicle.position[1]
        ahead = vehicle.rotation[0, 0] * north + vehicle.rotation[1, 0] * east
        side = vehicle.rotation[0, 1] * north + vehicle.rotation[1, 1] * east
        bearing = math.atan2(side, ahead)
        margin = margin_m / max(math.hypot(north, east), margin_m)
        inside[i] = bearing + margin >= port and bearing - margin <= starboard
    return inside
