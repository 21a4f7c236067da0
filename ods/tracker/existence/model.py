"""All numbers of the existence model that are set by hand; evidence.c says how they are used."""

from typing import NamedTuple

import numpy as np


class ExistenceModel(NamedTuple):
    """`scans`: scans in which a track could have had an echo; "weight": scans or echoes that a prior counts for."""

    object_hit_rate: float = 0.85
    """Mean of the beta law of an object's hit rate,"""
    object_scans: float = 8.0
    """and its weight; so many scans of a track count whole, though the sonar is at rest (`Coherence`)."""
    clutter_hit_rate: float = 0.3
    """The same of persistent clutter,"""
    clutter_scans: float = 12.0
    """and its weight,"""
    crowded_scans: float = 8.0
    """and its weight where clutter is crowded: there more of it is seen in nearly all scans."""
    crowd_a_second: float = 180.0
    """Clutter echoes a second at which clutter is half crowded:"""
    crowd_power: float = 8.0
    """1 / (1 + (crowd / echoes)^power)."""

    sharp: float = 1.06
    """Longest rise of a sharp echo, in widths of the point response."""
    object_sharp: float = 3.0
    """Beta law of an object's share of sharp echoes: sharp ones,"""
    object_slow: float = 1.5
    """and others."""
    clutter_sharp: float = 0.63
    """The same of clutter's: sharp ones,"""
    clutter_slow: float = 6.37
    """and others."""
    most_ratio: float = 3.0
    """Largest log-likelihood ratio of the onset for an object, and of the leading edge against one."""
    onset_enough: float = 8.0
    """Against an object the onset counts from this number of echoes on."""
    odds_factor: float = 3.3
    """Factor on the odds to confirm a new track where rises are measured: a few sharp echoes may be chance."""

    edge_limit: float = 1e-4
    """Limits of the probability of a leading edge: this, and 1 minus this."""
    object_edge: float = 5.2
    """Mean log-odds of objects' leading edges: lower than of most, as those among crests count;"""
    clutter_edge: float = -2.2
    """and of clutter's."""
    edge_variance: float = 2.5
    """Variance of what does not average away, for objects and clutter;"""
    edge_few: float = 6.0
    """a mean of n echoes has 1 + edge_few / n times that."""
    edge_fade: float = 0.85
    """Share of the sums that an echo leaves of those before: the last seven count."""
    edge_for: float = 9.0
    """Largest log-likelihood ratio of the leading edge for an object."""

    motion_for: float = 2.5
    """Largest log-likelihood ratio of motion for an object; against one it says nothing."""

    new_share: float = 0.1
    """Share of clutter among false tracks before any ended, where many echoes a scan measure a strength: the chain
    leaves few of noise;"""
    many: float = 10.0
    """half of that with this number, and next to none in calm water: (0.1 + echoes^2) / (many^2 + echoes^2)."""
    share_tracks: float = 30.0
    """Weight of that prior, tracks."""
    memory: float = 0.99
    """Share of the counts of ended tracks, scans and echoes that a scan leaves of those before: 15 s at 6.7 scans a
    second."""


EXISTENCE = ExistenceModel()
MODEL = np.array(EXISTENCE)
"""For C: `Model`."""
