"""The confirmed objects at one instant, as arrays: what the planner's list and the offline tracks are made of."""

from dataclasses import dataclass, replace

import numpy as np

from ods.base.arrays import Floats, Indices, Ints, Mask
from ods.tracker.map.hibernated import MapObject
from ods.tracker.observer.belief import Estimate
from ods.tracker.settings import MotionSettings
from ods.tracker.track import lifecycle
from ods.tracker.track.tracks import Tracks


@dataclass(frozen=True, slots=True)
class Picture:
    """n objects: (n,) or (3, n) NED arrays."""

    id: Ints
    state: Ints
    """a state of `life`."""
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

    def __len__(self) -> int:
        return len(self.id)

    def take(self, rows: Indices | Mask) -> "Picture":
        """Return the objects of an index array or a mask."""
        return Picture(*(getattr(self, name)[..., rows] for name in Picture.__slots__))

    def joined(self, other: "Picture") -> "Picture":
        """Return the objects of both."""
        return Picture(
            *(np.concatenate([getattr(self, name), getattr(other, name)], axis=-1) for name in Picture.__slots__)
        )

    def carried_on(self, dt: float | Floats, motion: MotionSettings) -> "Picture":
        """Return the same objects `dt` >= 0 seconds later, (n,) or one for all, each at its velocity.

        Errors of position and velocity are taken to go together, which a filter's are nearly: the standard deviation
        is never smaller than the filter's own prediction. To it comes what manoeuvres may add (`motion`).
        """
        manoeuvres = (1.0 - self.static) * motion.acceleration_noise * dt**3 / 3.0
        drift = self.static * motion.static_noise * dt
        grown = (self.sigma_position + self.sigma_velocity * dt) ** 2 + manoeuvres + drift
        return replace(self, position=self.position + self.velocity * dt, sigma_position=np.sqrt(grown))


def picture_of(tracks: Tracks, estimate: Estimate) -> Picture:
    """Return all confirmed objects of the live table with an estimate of its present state."""
    velocity, velocity_variance = tracks.observer.velocity()
    whole = Picture(
        tracks.id,
        tracks.state,
        estimate.position,
        velocity,
        np.maximum(estimate.radius, 0.0),
        np.sqrt(estimate.variance),
        estimate.covariance_ne,
        np.sqrt(np.maximum(velocity_variance, 0.0)),
        np.sqrt(estimate.radius_variance),
        tracks.existence,
        estimate.static,
        tracks.echoes,
        tracks.first_utc,
        tracks.last_utc,
    )
    return whole.take(tracks.state != lifecycle.TENTATIVE)


def picture_of_map(objects: list[MapObject]) -> Picture:
    """Return hibernated objects of the archive."""
    return Picture(
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
    )


def map_objects(picture: Picture, utc_ns: int) -> list[MapObject]:
    """Return the objects of a picture as hibernated at `utc_ns`."""
    positions, sigmas = picture.position.T.tolist(), picture.sigma_position.T.tolist()
    return [
        MapObject(
            id=int(picture.id[i]),
            position=tuple(positions[i]),
            sigma=tuple(sigmas[i]),
            radius=float(picture.radius[i]),
            sigma_radius=float(picture.sigma_radius[i]),
            existence=float(picture.existence[i]),
            times_seen=int(picture.times_seen[i]),
            first_seen_utc_ns=int(picture.first_seen_utc_ns[i]),
            last_seen_utc_ns=int(picture.last_seen_utc_ns[i]),
            hibernated_utc_ns=utc_ns,
            covariance_ne=float(picture.covariance_ne[i]),
        )
        for i in range(len(picture))
    ]
