"""Simulated images of a high-resolution imaging sonar in a water tank.

128 beams x 500 samples over 30 degrees, cells of about 1 cm, 8-bit logarithmic. Household-sized bodies, 0.2 to 0.6 m,
that show as filled patches, as near edges, as outlines or as a few glints, 10 to 25 dB over a floor that shines
unevenly, with shadows behind them; walls of the tank as bright lines with their multiple echoes; speckle that is
correlated over a few cells in range and beam; a gain ramp. What factor the logarithm has is often not known of such
recordings: the declared one differs from the one that was used.
"""

import numpy as np
from scipy.ndimage import gaussian_filter

from ods.assess.images.labelled import LABEL_MARGIN, LabelledImage, Target
from ods.base.arrays import Bytes, Floats, Mask
from ods.messages import Ping

TANK_BEAMS, TANK_SAMPLES = 128, 500
HALF_FAN_RAD = float(np.radians(15.0))
DR_M, NEAR_M = 0.01, 1.0
DECLARED_FACTORS = (40.0, 63.75, 100.0)
"""Counts a decade that an image may be declared to have; it is made with the middle one, 80 dB over 255 counts."""
DECADE_COUNTS = 63.75

_RANGE = NEAR_M + DR_M * np.arange(TANK_SAMPLES)
_BEARING = np.linspace(-HALF_FAN_RAD, HALF_FAN_RAD, TANK_BEAMS)
_ACROSS = np.sin(_BEARING)[:, None] * _RANGE
_AHEAD = np.cos(_BEARING)[:, None] * _RANGE


def tank_images(count: int, seed: int) -> list[LabelledImage]:
    """Return `count` images; the same seed gives the same bytes."""
    return [tank_image(np.random.default_rng([seed, index]), index) for index in range(count)]


def tank_image(rng: np.random.Generator, index: int) -> LabelledImage:
    """Return one image with one to four objects; none of its ranges is absolute."""
    level = _floor(rng)
    floor = level.copy()
    targets: list[Target] = []
    taken = np.zeros(level.shape, np.bool_)
    for _ in range(rng.integers(1, 5)):
        target = _add_body(rng, floor, level, taken)
        if target is not None:
            targets.append(target)
    for _ in range(rng.integers(0, 3)):
        _add_wall(rng, floor, level, taken)
    offset = rng.uniform(-40.0, 20.0)  # below 0: what is dark shows nothing at all
    counts = offset + DECADE_COUNTS / 20.0 * (level + 20.0 * np.log10(_speckle(rng)))
    frame = np.clip(np.rint(counts), 0, 255).astype(np.uint8)
    factor = DECLARED_FACTORS[index % len(DECLARED_FACTORS)]
    return LabelledImage(_ping(frame, index, factor), targets)


def _ping(frame: Bytes, index: int, factor: float) -> Ping:
    return Ping(
        seq=index,
        ping_number=index,
        t_ns=0,
        t_rx_ns=0,
        utc_ns=0,
        beams=TANK_BEAMS,
        samples=TANK_SAMPLES,
        dtype="u1",
        data=frame.tobytes(),
        bearing_rad=_BEARING.tolist(),
        range0_m=NEAR_M,
        dr_m=DR_M,
        sound_speed=1500.0,
        scale="log8",
        scale_factor=factor,
    )


def _floor(rng: np.random.Generator) -> Floats:
    """Return the mean level, dB over the receiver's noise: a floor between two ranges, uneven, with a gain ramp."""
    begin, end = rng.uniform(1.2, 2.5), rng.uniform(4.0, 6.0)
    slope = rng.uniform(0.1, 0.5)
    lit = 1.0 / (1.0 + np.exp(-(_RANGE - begin) / slope)) / (1.0 + np.exp((_RANGE - end) / slope))
    texture = gaussian_filter(rng.normal(size=(TANK_BEAMS, TANK_SAMPLES)), (rng.uniform(4, 15), rng.uniform(10, 40)))
    texture *= rng.uniform(0.5, 2.5) / texture.std()
    edges = 1.0 - rng.uniform(0.0, 0.5) * (np.abs(_BEARING) / HALF_FAN_RAD) ** 4
    ramp = rng.uniform(-6.0, 6.0) * (np.arange(TANK_SAMPLES) / TANK_SAMPLES - 0.5)
    power = 1.0 + 10.0 ** ((rng.uniform(3.0, 18.0) + texture) / 10.0) * lit * edges[:, None]
    return np.asarray(10.0 * np.log10(power) + ramp + 8.0)


def _add_body(rng: np.random.Generator, floor: Floats, level: Floats, taken: Mask) -> Target | None:
    """Add a body's echo and its shadow to level, where there is room; return its label."""
    for _ in range(20):
        size = rng.uniform(0.1, 0.3)
        distance, bearing = rng.uniform(1.6, 4.8), rng.uniform(-0.85, 0.85) * HALF_FAN_RAD
        x, y = distance * np.sin(bearing), distance * np.cos(bearing)
        around = np.hypot(_ACROSS - x, _AHEAD - y) < size + 0.15
        if not taken[around].any():
            break
    else:
        return None
    taken |= around
    turn, flat = rng.uniform(0.0, np.pi), rng.uniform(0.3, 1.0)
    u = (np.cos(turn) * (_ACROSS - x) + np.sin(turn) * (_AHEAD - y)) / size
    v = (np.cos(turn) * (_AHEAD - y) - np.sin(turn) * (_ACROSS - x)) / (flat * size)
    body = np.hypot(u, v) < 1.0
    shown = _shown(rng, body, u, v, y)
    background = float(np.median(floor[body]))
    strength = background + rng.uniform(10.0, 25.0)
    level[_shadow_of(body, rng.uniform(0.1, 0.6))] -= rng.uniform(3.0, 12.0)
    np.maximum(level, 5.0, out=level)
    uneven = gaussian_filter(rng.normal(size=level.shape), 3.0)
    echo = strength - 4.0 + 4.0 * np.clip(uneven / uneven.std(), -2.0, 1.0)
    level[shown] = np.maximum(level[shown], echo[shown])
    return _label(shown)


def _shown(rng: np.random.Generator, body: Mask, u: Floats, v: Floats, y: float) -> Mask:
    """Return the cells of a body that shine: all, its near half, its outline, or a few glints."""
    kind = rng.integers(4)
    if kind == 0:
        return body
    if kind == 1:
        return np.asarray(body & (y > _AHEAD))
    if kind == 2:
        return np.asarray(body & (np.hypot(u, v) > 0.75))
    glints = np.zeros(body.shape, np.bool_)
    cells = np.argwhere(body)
    for beam, sample in cells[rng.integers(len(cells), size=4)]:
        near = np.hypot(_ACROSS - _ACROSS[beam, sample], _AHEAD - _AHEAD[beam, sample])
        glints |= near < rng.uniform(0.03, 0.06)
    return glints


def _shadow_of(body: Mask, length_m: float) -> Mask:
    cells = round(length_m / DR_M)
    behind = np.cumsum(body, axis=1)
    before = np.pad(behind, ((0, 0), (cells, 0)))[:, :TANK_SAMPLES]
    return np.asarray((behind - before > 0) & ~body)


def _label(shown: Mask) -> Target:
    beams, samples = np.nonzero(shown.any(axis=1))[0], np.nonzero(shown.any(axis=0))[0]
    first, last = max(0, beams[0] - LABEL_MARGIN), min(TANK_BEAMS - 1, beams[-1] + LABEL_MARGIN)
    near, far = NEAR_M + DR_M * (samples[0] - LABEL_MARGIN), NEAR_M + DR_M * (samples[-1] + LABEL_MARGIN)
    return Target((float(near), float(far)), (float(_BEARING[first]), float(_BEARING[last])))


def _add_wall(rng: np.random.Generator, floor: Floats, level: Floats, taken: Mask) -> None:
    """Add a straight line of echoes, and a weaker second one behind it."""
    distance, turn = rng.uniform(4.6, 5.6), rng.uniform(-0.5, 0.5)
    strength = rng.uniform(8.0, 22.0)
    stop = rng.uniform(-1.0, 1.0) * HALF_FAN_RAD if rng.random() < 0.5 else HALF_FAN_RAD
    for copy, loss in ((0.0, 0.0), (rng.uniform(0.15, 0.4), rng.uniform(4.0, 10.0))):
        off = np.cos(turn) * _AHEAD + np.sin(turn) * _ACROSS - distance - copy
        line = (np.abs(off) < rng.uniform(0.02, 0.05)) & (_BEARING[:, None] < stop) & ~taken
        level[line] = np.maximum(level[line], floor[line] + strength - loss)


def _speckle(rng: np.random.Generator) -> Floats:
    """Return the amplitude of speckle of mean intensity 1, of one to three looks, correlated over a few cells."""
    looks = rng.integers(1, 4)
    width = rng.uniform(0.7, 1.1), rng.uniform(0.6, 1.5)
    power = np.zeros((TANK_BEAMS, TANK_SAMPLES))
    for _ in range(2 * looks):
        power += gaussian_filter(rng.normal(size=power.shape), width) ** 2
    return np.asarray(np.sqrt(power / power.mean()))
