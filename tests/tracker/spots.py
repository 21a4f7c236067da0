"""A place that has an echo in each image, among spots that come and go."""

import numpy as np

from ods.tracker.settings import TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.samples import RATE_HZ, scan


def told_after(
    wander_m: float, *, onset: float = 0.0, of_spots: float = 0.0, front: float = 0.0, rate_hz: float = RATE_HZ
) -> float:
    """Return when it is reported, s, among 20 spots that have an echo in one image of three for 10 s before it begins.

    onset, front: of its echoes; of_spots: the onset of theirs; rate_hz: the same images come so fast, and all times are
    those of `RATE_HZ`.
    """
    rng, tracker = np.random.default_rng(6), Tracker(TrackerSettings())
    spots = [(rng.uniform(45.0, 75.0), rng.uniform(-0.7, 0.7)) for _ in range(20)]
    for k in range(round(20.0 * RATE_HZ)):
        lit = [(r + rng.normal(0.0, 0.8), b) for r, b in spots if rng.random() < 0.3]
        there = k > 10.0 * RATE_HZ
        lit += [(60.0 + rng.normal(0.0, wander_m), 0.1)] * there
        rows = [(r, b + rng.normal(0.0, 0.008), 1.0) for r, b in lit]
        image = scan(k / rate_hz, np.array([0.0, 0.0, 4.0]), 0.0, rows)
        image.echoes.rows.strength[:] = rng.normal(13.0, 1.0, len(lit))
        image.echoes.rows.onset[:] = of_spots
        if there:
            image.echoes.rows.onset[-1], image.echoes.rows.front[-1] = onset, front
        tracker.step(image)
        where = tracker.snapshot().position[:2] - 60.0 * np.array([[np.cos(0.1)], [np.sin(0.1)]])
        if (np.hypot(*where) < 1.5).any():
            return k / RATE_HZ - 10.0
    return np.inf
