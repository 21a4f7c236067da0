"""Forms of the covariance update of a filter for position and velocity, against 60 digits.

Each cell of a grid is a filter with its own noise ratio and interval: measurement variances of 1 m^2 and of `ratio` m^2
in random order, after a time update of `dt` each. Worst case over all updates.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ods.base.arrays import Mask

Numbers = NDArray[Any]
"""float32 or float64."""
DIGITS = 60
ACCELERATION_NOISE = 0.01
"""m^2/s^3."""
TIMED_FILTERS = 300


@dataclass(frozen=True)
class Effort:
    """The grid and how long each filter runs."""

    ratios: Sequence[float]
    intervals: Sequence[float]
    updates: int
    """Of each filter."""
    rounds: int
    """Of the timing."""


FULL = Effort([10.0**e for e in range(-16, 17)], [10.0**e for e in range(-9, 6)], 2048, 300)
QUICK = Effort([1e-16, 1.0, 1e16], [1e-9, 1e-1, 1e5], 20, 5)


class Form(Protocol):
    """Covariances of many filters."""

    def __init__(self, count: int, dtype: type[np.floating[Any]]) -> None: ...

    def predict(self, dt: Any) -> None:
        """Time update over (n,) or one interval."""

    def update(self, noise: Numbers) -> None:
        """Measurement update with (n,) variances."""

    def matrix(self) -> tuple[Numbers, Numbers, Numbers, Numbers]:
        """Return position, upper and lower mixed, velocity entries of the covariances."""

    def positive(self) -> Mask:
        """Return which are positive definite."""


class Standard:
    """P - K H P, the cheapest of the textbook's."""

    def __init__(self, count: int, dtype: type[np.floating[Any]]) -> None:
        self.pp, self.vv = np.ones(count, dtype), np.ones(count, dtype)
        self.pv, self.vp = np.zeros(count, dtype), np.zeros(count, dtype)

    def predict(self, dt: Any) -> None:
        """F P F' + Q."""
        q = ACCELERATION_NOISE
        upper, lower = self.pv + dt * self.vv, self.vp + dt * self.vv
        self.pp = self.pp + dt * self.vp + dt * upper + q * dt**3 / 3.0
        self.pv, self.vp = upper + q * dt**2 / 2.0, lower + q * dt**2 / 2.0
        self.vv = self.vv + q * dt

    def update(self, noise: Numbers) -> None:
        """P - K H P."""
        innovation = self.pp + noise
        k1, k2 = self.pp / innovation, self.vp / innovation
        self.vv = self.vv - k2 * self.pv
        self.vp = self.vp - k2 * self.pp
        self.pv = self.pv - k1 * self.pv
        self.pp = self.pp - k1 * self.pp

    def matrix(self) -> tuple[Numbers, Numbers, Numbers, Numbers]:
        """See `Form`."""
        return self.pp, self.pv, self.vp, self.vv

    def positive(self) -> Mask:
        """See `Form`; in extended precision, so that only the filter's own rounding is judged."""
        pp, pv, vp, vv = (each.astype(np.longdouble) for each in self.matrix())
        return np.asarray((pp > 0) & (vv > 0) & (pp * vv - pv * vp > 0))


class Joseph(Standard):
    """(I - K H) P (I - K H)' + K R K'."""

    def update(self, noise: Numbers) -> None:
        """Joseph's form."""
        innovation = self.pp + noise
        k1, k2 = self.pp / innovation, self.vp / innovation
        left = 1.0 - k1
        pp, pv = left * self.pp, left * self.pv
        vp, vv = self.vp - k2 * self.pp, self.vv - k2 * self.pv
        self.pp = pp * left + k1 * k1 * noise
        self.pv = pv - k2 * pp + k1 * k2 * noise
        self.vp = vp * left + k1 * k2 * noise
        self.vv = vv - k2 * vp + k2 * k2 * noise


class Factors:
    """P = L D L', as in the tracker (`ods/tracker/observer/axis_kalman.h`), here for numbers of either precision."""

    def __init__(self, count: int, dtype: type[np.floating[Any]]) -> None:
        self.variance, self.slope, self.residual = np.ones(count, dtype), np.zeros(count, dtype), np.ones(count, dtype)

    def predict(self, dt: Any) -> None:
        """Time update."""
        variance, residual, q = self.variance, self.residual, ACCELERATION_NOISE
        turn = self.slope * dt
        self.variance = variance * (1.0 + turn) ** 2 + residual * dt**2 + q * dt**3 / 3.0
        covariance = variance * self.slope * (1.0 + turn) + residual * dt + q * dt**2 / 2.0
        mixed = variance * ((1.0 + turn / 2.0) ** 2 + turn**2 / 12.0) + residual * (dt**2 / 3.0)
        determinant = variance * residual + q * dt * mixed + q**2 * dt**4 / 12.0
        self.slope, self.residual = covariance / self.variance, determinant / self.variance

    def update(self, noise: Numbers) -> None:
        """Measurement update: slope and residual stay."""
        self.variance = self.variance / (self.variance + noise) * noise

    def matrix(self) -> tuple[Numbers, Numbers, Numbers, Numbers]:
        """See `Form`; multiplied out in extended precision: only the filter's own rounding is judged."""
        factors = self.variance, self.slope, self.residual
        variance, slope, residual = (x.astype(np.longdouble) for x in factors)
        return variance, slope * variance, slope * variance, residual + slope**2 * variance

    def positive(self) -> Mask:
        """See `Form`."""
        return np.asarray((self.variance > 0) & (self.residual > 0) & np.isfinite(self.slope))


FORMS: dict[str, type[Form]] = {"standard": Standard, "Joseph": Joseph, "L D L'": Factors}
TYPES: dict[str, type[np.floating[Any]]] = {"float32": np.float32, "float64": np.float64}


@dataclass(frozen=True)
class Panel:
    """One form in one precision: (intervals, ratios) arrays."""

    error: Numbers
    """Worst relative error of an entry of the covariance."""
    asymmetry: Numbers
    """Largest difference of the mixed entries, over the standard deviations."""
    broken: Mask
    """At some time not positive definite."""
    microseconds: float
    """A time and a measurement update of `TIMED_FILTERS` filters, median."""


@dataclass(frozen=True)
class Grid:
    """All forms in both precisions."""

    effort: Effort
    panels: dict[tuple[str, str], Panel]
    """By precision and form."""


def measure(effort: Effort, seed: int = 1) -> Grid:
    """Return what becomes of every form."""
    coarse = np.random.default_rng(seed).random(effort.updates) < 0.5
    panels = {}
    for precision, dtype in TYPES.items():
        ratios = np.array(effort.ratios, dtype)
        truth = [[exact(ratio, dt, coarse) for ratio in ratios.tolist()] for dt in effort.intervals]
        spent = _microseconds(dtype, effort.rounds)
        for name, form in FORMS.items():
            rows = [
                _run(form, dtype, ratios, dt, coarse, np.array(t))
                for dt, t in zip(effort.intervals, truth, strict=True)
            ]
            error, asymmetry, broken = (np.array(column) for column in zip(*rows, strict=True))
            panels[precision, name] = Panel(error, asymmetry, broken, spent[name])
    return Grid(effort, panels)


def exact(ratio: float, dt: float, coarse: Mask) -> NDArray[np.longdouble]:
    """Return (updates, 3) position, mixed and velocity entries, computed with `DIGITS` digits."""
    rows = []
    with localcontext(prec=DIGITS):
        q, h, one, other = Decimal(ACCELERATION_NOISE), Decimal(dt), Decimal(1), Decimal(ratio)
        added = (q * h**3 / 3, q * h**2 / 2, q * h)
        pp, pv, vv = Decimal(1), Decimal(0), Decimal(1)
        for is_other in coarse.tolist():
            pp += h * (2 * pv + h * vv) + added[0]
            pv += h * vv + added[1]
            vv += added[2]
            r = other if is_other else one
            innovation = pp + r
            pp, pv, vv = pp * r / innovation, pv * r / innovation, vv - pv * pv / innovation
            rows.append([np.longdouble(str(value)) for value in (pp, pv, vv)])
    return np.array(rows)


def _run(
    form: type[Form],
    dtype: type[np.floating[Any]],
    ratios: Numbers,
    dt: float,
    coarse: Mask,
    truth: NDArray[np.longdouble],
) -> tuple[Numbers, Numbers, Mask]:
    """Run filters of all (n,) ratios; `truth` is (n, updates, 3). Return worst error, asymmetry, and if it broke."""
    filters = form(len(ratios), dtype)
    error, asymmetry = np.zeros(len(ratios)), np.zeros(len(ratios))
    broken = np.zeros(len(ratios), bool)
    plain = np.ones_like(ratios)
    with np.errstate(all="ignore"):
        for k, is_other in enumerate(coarse.tolist()):
            filters.predict(dt)
            filters.update(ratios if is_other else plain)
            pp, pv, vp, vv = (each.astype(np.longdouble) for each in filters.matrix())
            true_pp, true_pv, true_vv = truth[:, k].T
            scale = np.sqrt(true_pp * true_vv)
            entries = [abs(pp - true_pp) / true_pp, abs(pv - true_pv) / scale, abs(vv - true_vv) / true_vv]
            error = np.maximum(error, np.nan_to_num(np.max(entries, axis=0), nan=np.inf).astype(float))
            asymmetry = np.fmax(asymmetry, (abs(pv - vp) / scale).astype(float))
            broken |= ~filters.positive()
    return error, asymmetry, broken


def _microseconds(dtype: type[np.floating[Any]], rounds: int) -> dict[str, float]:
    """Return the time of one step of every form, taken in turns."""
    noise = np.full(TIMED_FILTERS, 0.01, dtype)
    steps = {name: _step(form(TIMED_FILTERS, dtype), noise) for name, form in FORMS.items()}
    spent: dict[str, list[float]] = {name: [] for name in steps}
    for _ in range(rounds):
        for name, step in steps.items():
            step()
            began = time.perf_counter()
            step()
            spent[name].append(1e6 * (time.perf_counter() - began))
    return {name: float(np.median(times)) for name, times in spent.items()}


def _step(filters: Form, noise: Numbers) -> Callable[[], None]:
    def step() -> None:
        filters.predict(1.0 / 7.0)
        filters.update(noise)

    return step
