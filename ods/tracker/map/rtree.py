"""The R-tree of places, as SQLite's rtree module keeps it: in the map file, and in memory for objects that sleep.

The R-tree holds single precision numbers, rounded outwards: what it finds in a box is looked at once more exactly.
"""

PLACE_TABLE = "CREATE VIRTUAL TABLE place USING rtree(id, north_min, north_max, east_min, east_max)"
INSIDE = "north_max >= ? AND north_min <= ? AND east_max >= ? AND east_min <= ?"
"""Condition on `place`; takes the four numbers of `square_around`."""


def square_around(north: float, east: float, distance: float) -> tuple[float, float, float, float]:
    """Return the square around a place that holds all places not farther than `distance`."""
    return north - distance, north + distance, east - distance, east + distance
