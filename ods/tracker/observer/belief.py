"""The belief of an observer: one or more hypotheses of how each object moves, and their mixture."""

from typing import NamedTuple

from ods.base.arrays import Floats


class Belief(NamedTuple):
    """h hypotheses of n objects; positions are north, east, down."""

    weight: Floats
    """(h, n) probability of each hypothesis; they sum to 1."""
    position: Floats
    """(h, 3, n)."""
    variance: Floats
    """(h, 3, n) of the position: of north and east at a given height."""
    covariance_ne: Floats
    """(h, n) of north and east at a given height."""
    by_height: Floats
    """(h, 2, n) by how much north and east are larger for each metre that the object is lower."""
    shared: Floats
    """(h, 3, n) what no number of pings takes away: variances of north and east and their covariance, m^2, by the
    height, which the fan does not resolve, and by the bias of the pose; if static, by its slow drift (`creep`)."""
    radius: Floats
    """(n,) the filters' own: it follows their next correction."""
    radius_variance: Floats
    """(n,), too."""
    static: Floats
    """(n,) probability that the object does not move."""
    restless: Floats
    """(n,) by how much the spectral density of its acceleration, if it moves, is now over `acceleration_noise`,
    m^2/s^3; 0: the observer knows one kind of motion alone."""


class Estimate(NamedTuple):
    """Mean and covariance of n objects, all hypotheses taken together: the first two moments of their mixture."""

    position: Floats
    """(3, n)."""
    variance: Floats
    """(3, n); this and the next three as in `Belief`."""
    covariance_ne: Floats
    """(n,)."""
    by_height: Floats
    """(2, n)."""
    shared: Floats
    """(3, n)."""
    radius: Floats
    """(n,) and the next two: as in `Belief`."""
    radius_variance: Floats
    static: Floats
