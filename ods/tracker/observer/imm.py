"""North and east in one filter, so that the noise of range and bearing keeps its shape; one or more kinds of motion.

Moving objects may be followed by several filters that differ in how much the velocity changes, each with its share of
belief: interacting multiple models (H. A. P. Blom, Y. Bar-Shalom, IEEE Trans. Automatic Control 33, 1988). The models
exchange their states before each measurement, as much as the time since the last one lets an object change its ways.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.base.kernel import kernel
from ods.tracker.measurement.model import Fix
from ods.tracker.observer import ud_filter
from ods.tracker.observer.motion_hypotheses import Places
from ods.tracker.observer.track_table import Columns
from ods.tracker.observer.ud_filter import FACTORS, VELOCITY
from ods.tracker.settings import MotionSettings

LEAST_SHARE = 1e-6
"""No model's share falls below this."""


class Model(NamedTuple):
    """A way in which objects move."""

    noise: float
    """Spectral density of the acceleration, m^2/s^3."""
    share: float
    """How often, of all the time, an object moves so."""


class CoupledPlane:
    """See `ods.tracker.observer.motion_hypotheses.Plane`."""

    def __init__(self, settings: MotionSettings, models: Sequence[Model], change_rate: float = 0.0) -> None:
        """Follow moving objects by `models`, between which they change `change_rate` times a second."""
        self._settings = settings
        self._noise = np.array([model.noise for model in models])
        self._share = np.array([model.share for model in models])
        self._change_rate = change_rate
        self._hypotheses = 1 + len(models)
        self._columns = Columns(self._hypotheses * FACTORS + len(models), np.float64)

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        _predict(self._state(), dt, self._settings.static_noise, self._noise)

    def places(self) -> Places:
        """Return where objects are."""
        return Places(self._shares(), *_places(self._state()))

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (2, n) of the velocity of objects if they move."""
        moments = _velocity(self._state(), self._shares())
        return moments[0], moments[1]

    def append(self, position: Floats, north: Floats, east: Floats, mixed: Floats) -> None:
        """Append objects at (2 or more, k) positions, their variances and covariances (k,); the velocity is unknown."""
        first, count = len(self._columns), len(north)
        self._columns.append(np.zeros((len(self._columns.data), count)))
        self._state()[:, :2, first:] = position[:2]
        self._shares()[:, first:] = self._share[:, None]
        _start(self._state(), first, np.stack([north, east, mixed]), self._settings.velocity_sigma**2)

    def update(self, rows: Indices, fix: Fix, since_s: Floats) -> Floats:
        """Take one fix an object; return (k,) the log of the likelihood if it is static over that if it moves."""
        return _update(self._state(), self._shares(), rows, fix, since_s, self._share, self._change_rate)

    def rest_there(self, rows: Indices) -> None:
        """Start the static hypothesis anew where the likeliest of the moving ones is now."""
        _rest_there(self._state(), self._shares(), rows)

    def set_out(self, rows: Indices) -> None:
        """Start the moving hypotheses anew where the static one is, with unknown velocity."""
        self._shares()[:, rows] = self._share[:, None]
        _set_out(self._state(), rows, self._settings.velocity_sigma**2)

    def join(self, heirs: Indices, old: Indices) -> None:
        """Let the static hypotheses of `heirs` learn where those of `old`, the same objects, were."""
        _join(self._state()[0], heirs, old)

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""
        self._columns.keep(mask)

    def _state(self) -> Floats:
        """Return the (hypotheses, FACTORS, n) filters, the static one first: a view."""
        s = self._columns.data
        return s[: self._hypotheses * FACTORS].reshape(self._hypotheses, FACTORS, s.shape[1])

    def _shares(self) -> Floats:
        """Return the (models, n) probabilities of the models if the object moves: a view."""
        view: Floats = self._columns.data[self._hypotheses * FACTORS :]
        return view


# The kernels work on the (hypotheses, FACTORS, n) table `s`, in place.


@kernel
def _start(s: Floats, first: int, covariance: Floats, velocity_variance: float) -> None:
    """Set the (3, k) variances and covariances of objects from `first` on."""
    for h in range(len(s)):
        for k in range(covariance.shape[1]):
            north, east, mixed = covariance[0, k], covariance[1, k], covariance[2, k]
            ud_filter.start(s[h], first + k, north, east, mixed, 0.0 if h == 0 else velocity_variance)


@kernel
def _predict(s: Floats, dt: float, static_noise: float, noise: Floats) -> None:
    work, weight = np.empty((4, ud_filter.PROCESS_COLUMNS)), np.empty(ud_filter.PROCESS_COLUMNS)
    for i in range(s.shape[2]):
        ud_filter.drift(s[0], i, static_noise * dt)
        for m in range(len(noise)):
            ud_filter.predict(s[1 + m], i, dt, noise[m], work, weight)


@kernel
def _places(s: Floats) -> tuple[Floats, Floats, Floats]:
    hypotheses, _, n = s.shape
    position, variance = np.empty((hypotheses, 2, n)), np.empty((hypotheses, 2, n))
    covariance = np.empty((hypotheses, n))
    for h in range(hypotheses):
        for i in range(n):
            position[h, 0, i], position[h, 1, i] = s[h, 0, i], s[h, 1, i]
            variance[h, 0, i], variance[h, 1, i], covariance[h, i] = ud_filter.place_covariance(s[h], i)
    return position, variance, covariance


@kernel
def _velocity(s: Floats, shares: Floats) -> Floats:
    """Return (2, 2, n) mean and variance of the moving hypotheses taken together."""
    moments = np.zeros((2, 2, s.shape[2]))
    for i in range(s.shape[2]):
        for m in range(len(shares)):
            for axis in range(2):
                moments[0, axis, i] += shares[m, i] * s[1 + m, VELOCITY + axis, i]
        for m in range(len(shares)):
            variances = ud_filter.velocity_variances(s[1 + m], i)
            for axis in range(2):
                offset = s[1 + m, VELOCITY + axis, i] - moments[0, axis, i]
                moments[1, axis, i] += shares[m, i] * (variances[axis] + offset**2)
    return moments


@kernel
def _update(
    s: Floats, shares: Floats, rows: Indices, fix: Fix, since_s: Floats, usual: Floats, change_rate: float
) -> Floats:
    """Update all filters of `rows`; return the log of the ratio of both likelihoods of the fixes before that."""
    ratio, evidence = np.empty(len(rows)), np.empty(len(shares))
    old, count = np.empty((len(shares), FACTORS, 1)), 5 * len(shares)
    work, weight = np.empty((4, count)), np.empty(count)
    for k, i in enumerate(rows):
        if len(shares) > 1:
            _mix(s, shares, i, usual, math.exp(-change_rate * since_s[k]), old, work, weight)
        noise = fix.north[k], fix.east[k], fix.mixed[k]
        static = ud_filter.update(s[0], i, fix.position, k, noise[0], noise[1], noise[2])
        for m in range(len(shares)):
            evidence[m] = ud_filter.update(s[1 + m], i, fix.position, k, noise[0], noise[1], noise[2])
        ratio[k] = static - _weigh(shares, i, evidence)
    return ratio


@kernel
def _weigh(shares: Floats, i: int, evidence: Floats) -> float:
    """Update the shares of the models by their log-likelihoods; return that of all together."""
    best: float = evidence.max()
    total = 0.0
    for m in range(len(shares)):
        shares[m, i] = max(shares[m, i] * math.exp(evidence[m] - best), LEAST_SHARE * shares[m, i])
        total += shares[m, i]
    for m in range(len(shares)):
        shares[m, i] /= total
    return best + math.log(total)


@kernel
def _mix(
    s: Floats, shares: Floats, i: int, usual: Floats, stay: float, old: Floats, work: Floats, weight: Floats
) -> None:
    """Let the models exchange their states: with probability `stay` an object went on as before, else as `usual`.

    `old` (models, FACTORS, 1), `work` (4, 5 x models) and `weight` are scratch.
    """
    models = len(shares)
    before = shares[:, i].copy()
    old[:, :, 0] = s[1:, :, i]
    for to in range(models):
        shares[to, i] = stay * before[to] + (1.0 - stay) * usual[to]
        s[1 + to, :4, i] = 0.0
        for m in range(models):
            came = before[m] * ((1.0 - stay) * usual[to] + (stay if m == to else 0.0)) / shares[to, i]
            weight[4 * models + m] = came
            ud_filter.columns(old[m], 0, work, weight, 4 * m, came)
            for row in range(4):
                s[1 + to, row, i] += came * old[m, row, 0]
        for m in range(models):
            for row in range(4):
                work[row, 4 * models + m] = old[m, row, 0] - s[1 + to, row, i]
        ud_filter.triangular(s[1 + to], i, work, weight, 5 * models)


@kernel
def _rest_there(s: Floats, shares: Floats, rows: Indices) -> None:
    for i in rows:
        likeliest = s[1 + shares[:, i].argmax()]
        s[0, 0, i], s[0, 1, i] = likeliest[0, i], likeliest[1, i]
        north, east, mixed = ud_filter.place_covariance(likeliest, i)
        ud_filter.start(s[0], i, north, east, mixed, 0.0)


@kernel
def _set_out(s: Floats, rows: Indices, velocity_variance: float) -> None:
    for i in rows:
        north, east, mixed = ud_filter.place_covariance(s[0], i)
        for h in range(1, len(s)):
            s[h, :4, i] = s[0, :4, i]
            ud_filter.start(s[h], i, north, east, mixed, velocity_variance)


@kernel
def _join(static: Floats, heirs: Indices, old: Indices) -> None:
    for heir, before in zip(heirs, old):  # noqa: B905  numba knows no `strict`
        north, east, mixed = ud_filter.place_covariance(static, before)
        ud_filter.update(static, heir, static, before, north, east, mixed)
