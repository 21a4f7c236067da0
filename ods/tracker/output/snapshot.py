"""The confirmed objects at one instant, as arrays: what the planner's list and the offline tracks are made of."""

from dataclasses import dataclass, replace

import numpy as np

from ods.base.arrays import Floats, Indices, Ints, Mask
from ods.base.clock import NS
from ods.compiled import native
from ods.tracker.existence import lifecycle
from ods.tracker.map.map_object import MapObject
from ods.tracker.observer.registry import CHANGE_RATE
from ods.tracker.settings import MotionSettings
from ods.tracker.track.tracks import Tracks


@dataclass(frozen=True, slots=True)
class Snapshot:
    """n objects: (n,) or (3, n) NED arrays."""

    id: Ints
    state: Ints
    """A state of `lifecycle`."""
    position: Floats
    velocity: Floats
    radius: Floats
    sigma_position: Floats
    covariance_ne: Floats
    """(n,) of north and east position, m^2."""
    sigma_velocity: Floats
    sigma_radius: Floats
    existence: Floats
    static: Floats
    """(n,) probability that the object does not move."""
    times_seen: Ints
    first_seen_utc_ns: Ints
    last_seen_utc_ns: Ints
    unseen_s: Floats
    """(n,) part of the time since then in which the object was not observed, s."""
    restless: Floats
    """(n,) as in `Belief`."""

    def __len__(self) -> int:
        return len(self.id)

    def take(self, rows: Indices | Mask) -> "Snapshot":
        """Return the objects of an index array or a mask."""
        which = rows.nonzero()[0] if rows.dtype == np.bool_ else rows
        return Snapshot(*(getattr(self, name).take(which, axis=-1) for name in Snapshot.__slots__))

    def joined(self, other: "Snapshot") -> "Snapshot":
        """Return the objects of both."""
        return Snapshot(
            *(np.concatenate([getattr(self, name), getattr(other, name)], axis=-1) for name in Snapshot.__slots__)
        )

    def nearest(self, count: int, centre: Floats | None) -> "Snapshot":
        """Return the `count` objects whose edges are nearest to `centre`, (3,) NED; without one, the first `count`."""
        if len(self) <= count:
            return self
        if centre is None:
            return self.take(np.arange(count))
        distance = np.hypot(*(self.position[:2] - centre[:2, None])) - self.radius
        return self.take(np.sort(np.argpartition(distance, count)[:count]))

    def extrapolated(self, dt: float, motion: MotionSettings) -> "Snapshot":
        """Return the same objects `dt` >= 0 seconds later, as `places_after`."""
        (position,), (sigma,) = self.places_after(np.full((1, len(self)), dt), motion)
        return replace(self, position=position, sigma_position=sigma)

    def places_after(self, dt: Floats, motion: MotionSettings) -> tuple[Floats, Floats]:
        """Return where the objects are (k, n) >= 0 seconds later, each at its velocity: (k, 3, n) positions and their
        standard deviations.

        Errors of position and velocity are taken to go together, which a filter's are nearly: the standard deviation
        is never smaller than the filter's own prediction. To it comes what manoeuvres may add: what is usual
        (`motion`), and of those that manoeuvre now what they do beyond that, until they change their ways.
        """
        position, sigma = np.empty((2, len(dt), 3, len(self)))
        native.extrapolate(self.movers(motion), dt, position, sigma)
        return position, sigma

    def movers(self, motion: MotionSettings) -> tuple[Floats | float, ...]:
        """Return what kernels take (`MOVERS` of ahead.c)."""
        moving = self.position, self.velocity, self.sigma_position, self.sigma_velocity, self.static, self.restless
        return *map(np.ascontiguousarray, moving), motion.acceleration_noise, motion.static_noise, CHANGE_RATE


def snapshot_of(tracks: Tracks) -> Snapshot:
    """Return all confirmed objects of the live tracks."""
    history, (belief, estimate) = tracks.history, tracks.belief_and_moments()
    velocity, velocity_variance = tracks.velocity()
    variance = estimate.variance.copy()
    variance[:2] += estimate.shared[:2]
    whole = Snapshot(
        history.id,
        history.state,
        estimate.position,
        velocity,
        np.maximum(estimate.radius, 0.0),
        np.sqrt(variance),
        estimate.covariance_ne + estimate.shared[2],
        np.sqrt(np.maximum(velocity_variance, 0.0)),
        np.sqrt(estimate.radius_variance),
        tracks.existence,
        estimate.static,
        history.echoes,
        history.first_utc,
        history.last_utc,
        history.unwatched / NS,
        belief.restless,
    )
    return whole.take(history.state != lifecycle.TENTATIVE)


def snapshot_of_map(objects: list[MapObject]) -> Snapshot:
    """Return hibernated objects of the map."""
    return Snapshot(
        np.array([o.id for o in objects], np.int64),
        np.full(len(objects), lifecycle.HIBERNATED, np.int64),
        np.array([o.position for o in objects], np.float64).reshape(-1, 3).T,
        np.zeros((3, len(objects))),
        np.array([o.radius for o in objects], np.float64),
        np.array([o.sigma for o in objects], np.float64).reshape(-1, 3).T,
        np.array([o.covariance_ne for o in objects], np.float64),
        np.zeros((3, len(objects))),
        np.array([o.sigma_radius for o in objects], np.float64),
        np.array([o.existence for o in objects], np.float64),
        np.ones(len(objects)),
        np.array([o.times_seen for o in objects], np.int64),
        np.array([o.first_seen_utc_ns for o in objects], np.int64),
        np.array([o.last_seen_utc_ns for o in objects], np.int64),
        np.zeros(len(objects)),
        np.zeros(len(objects)),
    )


def map_objects(snapshot: Snapshot, utc_ns: int) -> list[MapObject]:
    """Return the objects of a snapshot as hibernated at `utc_ns`."""
    positions, sigmas = snapshot.position.T.tolist(), snapshot.sigma_position.T.tolist()
    return [
        MapObject(
            id=int(snapshot.id[i]),
            position=tuple(positions[i]),
            sigma=tuple(sigmas[i]),
            radius=float(snapshot.radius[i]),
            sigma_radius=float(snapshot.sigma_radius[i]),
            existence=float(snapshot.existence[i]),
            times_seen=int(snapshot.times_seen[i]),
            first_seen_utc_ns=int(snapshot.first_seen_utc_ns[i]),
            last_seen_utc_ns=int(snapshot.last_seen_utc_ns[i]),
            hibernated_utc_ns=utc_ns,
            covariance_ne=float(snapshot.covariance_ne[i]),
        )
        for i in range(len(snapshot))
    ]
