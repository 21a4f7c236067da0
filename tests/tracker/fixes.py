"""Measurements as an observer gets them."""

import numpy as np

from ods.base.arrays import Floats
from ods.tracker.measurement.model import UNSEEN, PositionMeasurement


def fixes_of(places: Floats, noise: Floats) -> PositionMeasurement:
    """Return measurements of k objects: (2, k) and (3, k), variances and covariance; nothing is known of heights."""
    zeros = np.zeros(places.shape[1])
    level = zeros, zeros, zeros + 1.0, zeros, np.zeros((2, len(zeros))), np.zeros((UNSEEN, 2, len(zeros))), np.zeros(2)
    nn, ee, ne = noise
    return PositionMeasurement(np.vstack([places, zeros]), nn, ee, ne, *level)
