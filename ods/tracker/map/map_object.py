"""An object of the map, as the file and the tracker know it."""

import msgspec


class MapObject(msgspec.Struct, frozen=True, gc=False, array_like=True):
    """A hibernated object, with what was known when it was last seen."""

    id: int
    position: tuple[float, float, float]
    """NED, m."""
    sigma: tuple[float, float, float]
    """Standard deviations of the position, m."""
    radius: float
    sigma_radius: float
    existence: float
    times_seen: int
    first_seen_utc_ns: int
    last_seen_utc_ns: int
    hibernated_utc_ns: int
    covariance_ne: float = 0.0
    """Covariance of north and east, m^2."""
