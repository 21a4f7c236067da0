"""Simulated tank images from another model than `ods.assess.images.tank`, held out from tuning.

Nothing but the ping's form is shared with it. Here objects are drawn from strokes: bottles, tyres, hooks, valves,
chains, cans, plates and lone knobs, of 2 to 20 dB over the floor around them; beams have a width and side lobes, so a
strong echo leaves a line across its range; speckle is that of a complex field with texture; the floor falls off by a
power law, with ripples and a steep edge; there are walls along and across the beams, interference lines and weak beams.
96 to 256 beams, 300 to 700 samples, 40 to 120 counts a decade, of which the ping declares others. An object counts when
a person would see it, that is when its echo stands out from the recorded counts around it.
"""

import math
from itertools import pairwise

import numpy as np
from scipy.ndimage import gaussian_filter, gaussian_filter1d

from ods.assess.images.labelled import LABEL_MARGIN, LabelledImage, Target
from ods.base.arrays import Bytes, Floats, Mask
from ods.messages import Ping

Strokes = list[tuple[Floats, float]]
"""Polylines (points, 2), in units of the object's half size, and their brightness, dB."""

BEAM_COUNTS = (96, 128, 256)
SHOWN_DB = -9.0
"""Under the object's brightest cell: what is weaker is not its label's."""
STANDS_OUT = 1.5
"""Standard deviations of the counts around, by which the mean of an object's echo is higher when it can be seen."""


class HeldOutScene:
    """The mean intensity of one image while it is put together."""

    def __init__(self, rng: np.random.Generator) -> None:
        """Choose the geometry and shine on the floor."""
        self.rng = rng
        self.beams = int(rng.choice(BEAM_COUNTS))
        self.samples = int(rng.integers(300, 701))
        self.bearing = math.radians(rng.uniform(12.0, 18.0)) * np.linspace(-1.0, 1.0, self.beams)
        self.near = rng.uniform(0.5, 2.0)
        self.step = rng.uniform(0.004, 0.012)
        self.distance = self.near + self.step * np.arange(self.samples)
        self.across = np.sin(self.bearing)[:, None] * self.distance
        self.ahead = np.cos(self.bearing)[:, None] * self.distance
        self.floor = self._floor()
        self.power = self.floor.copy()
        self.free = np.ones(self.power.shape, np.bool_)
        self.objects: list[Mask] = []

    def _floor(self) -> Floats:
        """Return the floor's intensity over that of the receiver's noise, which is 1."""
        rng, along = self.rng, np.linspace(0.0, 1.0, self.samples)
        begin, width = rng.uniform(-0.2, 0.3), rng.uniform(0.01, 0.2)
        lit = 1.0 / (1.0 + np.exp(-(along - begin) / width))
        falls = ((along + 0.3) / 0.8) ** -rng.uniform(0.0, 4.0)
        pattern = np.exp(-0.5 * (self.bearing / self.bearing[-1] / rng.uniform(0.8, 2.0)) ** 2)
        ripple = math.tau * (self.ahead + rng.uniform(-0.5, 0.5) * self.across) / rng.uniform(0.1, 0.5)
        patches = gaussian_filter(rng.normal(size=ripple.shape), (0.1 * self.beams, 0.06 * self.samples))
        db = rng.uniform(0.0, 1.5) * np.sin(ripple) + rng.uniform(0.0, 2.5) * patches / patches.std()
        level = 10.0 ** ((rng.uniform(0.0, 25.0) + db) / 10.0)
        return np.asarray(1.0 + level * lit * falls * pattern[:, None])

    def add_object(self) -> None:
        """Add one object with its shadow where there is room."""
        rng = self.rng
        for _ in range(30):
            beam = int(rng.integers(round(0.07 * self.beams), round(0.93 * self.beams)))
            sample = int(rng.integers(round(0.12 * self.samples), round(0.92 * self.samples)))
            size = 0.5 * self.step * self.samples * rng.uniform(0.04, 0.12)
            middle = (self.across[beam, sample], self.ahead[beam, sample])
            around = np.hypot(self.across - middle[0], self.ahead - middle[1]) < 1.6 * size + 8 * self.step
            if self.free[around].all():
                break
        else:
            return
        self.free &= ~around
        turn = rng.uniform(0.0, math.tau)
        u = (math.cos(turn) * (self.across - middle[0]) + math.sin(turn) * (self.ahead - middle[1])) / size
        v = (math.cos(turn) * (self.ahead - middle[1]) - math.sin(turn) * (self.across - middle[0])) / size
        thick = max(0.12, 1.2 * self.step / size)
        echo = np.zeros(self.power.shape)
        for points, db in _strokes(rng):
            echo = np.maximum(echo, 10.0 ** (db / 10.0) * np.exp(-((_away(points, u, v) / thick) ** 2)))
        away = np.hypot(u, v) < 1.5
        echo[~away] = 0.0
        echo *= np.exp(rng.uniform(0.2, 1.0) * _unit(gaussian_filter(rng.normal(size=echo.shape), 2.0)))
        echo /= echo.max()
        shown = echo > 10.0 ** (SHOWN_DB / 10.0)
        self._add_shadow(shown, size)
        self.power += 10.0 ** (rng.uniform(2.0, 20.0) / 10.0) * np.median(self.floor[shown]) * echo
        self.objects.append(shown)

    def _add_shadow(self, shown: Mask, size: float) -> None:
        cells = round(self.rng.uniform(0.5, 4.0) * size / self.step)
        seen = np.cumsum(shown, axis=1)
        behind = seen - np.pad(seen, ((0, 0), (cells, 0)))[:, : self.samples] > 0
        keep = 10.0 ** (-self.rng.uniform(0.0, 15.0) / 10.0)
        self.power[behind & ~shown] = 1.0 + keep * (self.power[behind & ~shown] - 1.0)

    def labels(self, counts: Bytes) -> list[Target]:
        """Return the labels of all objects in recorded samples."""
        return [self._label(shown, counts) for shown in self.objects]

    def _label(self, shown: Mask, counts: Bytes) -> Target:
        rows, columns = np.nonzero(shown.any(axis=1))[0], np.nonzero(shown.any(axis=0))[0]
        first, last = max(0, rows[0] - LABEL_MARGIN), min(self.beams - 1, rows[-1] + LABEL_MARGIN)
        near, far = max(0, columns[0] - LABEL_MARGIN), min(self.samples - 1, columns[-1] + LABEL_MARGIN)
        around = np.s_[max(0, 2 * first - last) : 2 * last - first, max(0, 2 * near - far) : 2 * far - near]
        others = counts[around][~shown[around]].astype(np.float64)
        seen = float(counts[shown].mean()) - others.mean() >= STANDS_OUT * others.std()
        return Target(
            (float(self.distance[near]), float(self.distance[far])),
            (float(self.bearing[first]), float(self.bearing[last])),
            counts=bool(seen),
        )

    def add_wall(self) -> None:
        """Add a wall across the beams or along them, where no object is."""
        rng = self.rng
        if rng.random() < 0.7:
            off = self.ahead - self.distance[-1] * rng.uniform(0.8, 1.0) + rng.uniform(-0.4, 0.4) * self.across
        else:
            side = rng.choice((-1.0, 1.0)) * rng.uniform(0.8, 1.0)
            off = self.across - side * self.across[-1, self.samples // 2] * np.ones_like(self.ahead)
        width = rng.uniform(1.0, 4.0) * self.step
        wall = 10.0 ** (rng.uniform(5.0, 25.0) / 10.0) * np.exp(-((off / width) ** 2))
        self.power += np.where(self.free, wall, 0.0) * np.median(self.floor)

    def counts(self) -> Bytes:
        """Return the recorded samples: beam pattern, side lobes, speckle, gain faults, logarithm."""
        rng = self.rng
        received = gaussian_filter1d(self.power, self.beams / 128 * rng.uniform(0.4, 1.0), axis=0, mode="nearest")
        received += 10.0 ** (-rng.uniform(25.0, 40.0) / 10.0) * received.mean(axis=0)
        intensity = received * self._speckle()
        if rng.random() < 0.3:
            intensity[:, rng.integers(self.samples)] *= 10.0 ** rng.uniform(0.2, 0.8)
        if rng.random() < 0.3:
            intensity[rng.integers(self.beams)] *= 10.0 ** -rng.uniform(0.2, 1.0)
        decade = rng.uniform(40.0, 120.0)
        db_level = 0.5 * decade * np.log10(intensity) + rng.uniform(-20.0, 40.0)
        return np.asarray(np.clip(np.rint(db_level), 0, 255).astype(np.uint8))

    def _speckle(self) -> Floats:
        """Return intensity of mean 1: a complex field of a given correlation times a texture, of one to four looks."""
        rng, shape = self.rng, self.power.shape
        width = rng.uniform(0.0, 1.6) * self.beams / 128, rng.uniform(0.0, 2.5)
        looks = int(rng.integers(1, 5))
        fields = [gaussian_filter(rng.normal(size=shape), width) ** 2 for _ in range(2 * looks)]
        texture = np.exp(rng.uniform(0.0, 0.4) * _unit(gaussian_filter(rng.normal(size=shape), 3.0)))
        power = np.sum(fields, axis=0) * texture
        return np.asarray(power / power.mean())


def held_out_images(count: int, seed: int) -> list[LabelledImage]:
    """Return `count` images; the same seed gives the same bytes."""
    return [_image(np.random.default_rng([seed, index]), index) for index in range(count)]


def _image(rng: np.random.Generator, index: int) -> LabelledImage:
    scene = HeldOutScene(rng)
    for _ in range(rng.integers(1, 5)):
        scene.add_object()
    for _ in range(rng.integers(0, 3)):
        scene.add_wall()
    counts = scene.counts()
    ping = Ping(
        seq=index,
        ping_number=index,
        t_ns=0,
        t_rx_ns=0,
        utc_ns=0,
        beams=scene.beams,
        samples=scene.samples,
        dtype="u1",
        data=counts.tobytes(),
        bearing_rad=scene.bearing.tolist(),
        range0_m=scene.near,
        dr_m=scene.step,
        sound_speed=1500.0,
        scale="log8",
        scale_factor=float(rng.uniform(40.0, 120.0)),
    )
    return LabelledImage(ping, scene.labels(counts))


def _strokes(rng: np.random.Generator) -> Strokes:
    """Return one of the eight kinds of objects, (across, ahead) within about -1..1."""
    round_ = np.linspace(0.0, math.tau, 25)
    ring = np.column_stack((np.cos(round_), np.sin(round_)))
    kind = rng.integers(8)
    if kind == 0:  # bottle: two sides, one brighter
        return [(_line(-1, -0.3, 1, -0.2), 0.0), (_line(-1, 0.3, 1, 0.2), -rng.uniform(3.0, 12.0))]
    if kind == 1:  # tyre
        return [(0.9 * ring, 0.0), (0.45 * ring, -rng.uniform(3.0, 10.0))]
    if kind == 2:  # hook
        return [(0.6 * ring[: rng.integers(12, 20)], 0.0), (_line(0.6, 0.0, 0.6, 1.0), -3.0)]
    if kind == 3:  # valve: a body and a hand-wheel
        return [(_line(-0.9, 0, 0.5, 0), 0.0), (_line(0.5, -0.6, 0.5, 0.6), -2.0), (0.25 * ring, -1.0)]
    if kind == 4:  # chain
        x = np.linspace(-1.0, 1.0, 12)
        return [(np.column_stack((x, 0.5 * np.sin(rng.uniform(2.0, 5.0) * x + rng.uniform(0.0, 6.0)))), 0.0)]
    if kind == 5:  # can: the near edge
        return [(0.7 * ring[6 : 6 + rng.integers(6, 12)], 0.0)]
    if kind == 6:  # plate: filled
        return [(_line(-0.8, y, 0.8, y), 0.0) for y in np.linspace(-0.4, 0.4, 6)]
    return [(_line(x, y, x + 0.05, y), 0.0) for x, y in rng.uniform(-0.6, 0.6, (int(rng.integers(1, 4)), 2))]  # knobs


def _line(x: float, y: float, to_x: float, to_y: float) -> Floats:
    return np.array(((x, y), (to_x, to_y)))


def _away(points: Floats, u: Floats, v: Floats) -> Floats:
    """Return the distance of each cell to a polyline."""
    least = np.full(u.shape, np.inf)
    for (x, y), (to_x, to_y) in pairwise(points):
        dx, dy = to_x - x, to_y - y
        share = np.clip(((u - x) * dx + (v - y) * dy) / max(dx * dx + dy * dy, 1e-12), 0.0, 1.0)
        least = np.minimum(least, np.hypot(u - x - share * dx, v - y - share * dy))
    return least


def _unit(field: Floats) -> Floats:
    return np.asarray(field / field.std())
