"""Dead ends across the way: half circles of posts without a gap."""

import math

import numpy as np

from ods.base.arrays import Floats
from ods.missions.settings import WorldSettings

POST_M = 1.0
"""Radius of a post, m."""
OVERLAP = 0.9
"""Distance from post to post over their diameter: less than 1, so that nothing shows between them."""
ASIDE = 0.5
"""Largest distance of a dead end's middle from the straight way, radii."""


def dead_ends(settings: WorldSettings, rng: np.random.Generator) -> Floats:
    """Return (n, 2) places of the posts, north, east, m."""
    across = settings.dead_end_m
    angles = np.linspace(-0.5 * math.pi, 0.5 * math.pi, math.ceil(math.pi * across / (OVERLAP * 2.0 * POST_M)) + 1)
    arc = across * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    north = settings.length_m * np.arange(1, settings.dead_ends + 1) / (settings.dead_ends + 1)
    east = ASIDE * across * rng.uniform(-1.0, 1.0, settings.dead_ends)
    middles = np.stack([north, east], axis=1)
    return np.asarray((middles[:, None] + arc).reshape(-1, 2))
