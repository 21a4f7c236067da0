"""What an observer believes of its objects: one or more hypotheses of how each moves, and their mixture."""

from dataclasses import dataclass

from ods.geometry import Array


@dataclass(frozen=True, slots=True)
class Belief:
    """h hypotheses of n objects; axis 0 of positions is north, east, down."""

    weight: Array
    """(h, n) probability of each hypothesis; they sum to 1."""
    position: Array
    """(3, h, n)."""
    variance: Array
    """(3, h, n) of the position."""
    covariance_ne: Array
    """(h, n) of north and east."""
    radius: Array
    """(n,)."""
    radius_variance: Array
    """(n,)."""
    static: Array
    """(n,) probability that the object does not move."""


@dataclass(frozen=True, slots=True)
class Estimate:
    """Mean and covariance of n objects."""

    position: Array
    """(3, n)."""
    variance: Array
    """(3, n)."""
    covariance_ne: Array
    """(n,)."""
    radius: Array
    radius_variance: Array
    static: Array


def mixture(belief: Belief) -> Estimate:
    """Return mean and covariance of the hypotheses taken together."""
    weight = belief.weight
    position = (weight * belief.position).sum(axis=1)
    offset = belief.position - position[:, None]
    return Estimate(
        position=position,
        variance=(weight * (belief.variance + offset**2)).sum(axis=1),
        covariance_ne=(weight * (belief.covariance_ne + offset[0] * offset[1])).sum(axis=0),
        radius=belief.radius,
        radius_variance=belief.radius_variance,
        static=belief.static,
    )
