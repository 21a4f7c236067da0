"""North and east in one filter, so that the noise of range and bearing keeps its shape; one or more kinds of motion.

Moving objects may be followed by several filters that differ in how much the velocity changes, each with its share of
belief: interacting multiple models (H. A. P. Blom, Y. Bar-Shalom, IEEE Trans. Automatic Control 33, 1988). The models
exchange their states once a second, as much as the time since the last exchange lets an object change its ways: what
costs as much as correcting all of them, and tells next to nothing from one ping to the next.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ods.base.arrays import Floats, Indices, Mask
from ods.compiled.kernel import inlined, kernel
from ods.tracker.measurement.model import UNSEEN, PositionMeasurement
from ods.tracker.named import Named, TrackTable, each
from ods.tracker.observer import sensitivity, ud_filter
from ods.tracker.observer.horizontal import RESTING, HorizontalState, Learned, NewPlaces, learned_rows
from ods.tracker.observer.sensitivity import STATE, Fix, Heights, Innovation, Place
from ods.tracker.observer.ud_filter import EAST, FACTORS, NORTH, STATE_ROWS, VELOCITY, Work
from ods.tracker.settings import MotionSettings

LEAST_PROBABILITY = 1e-6
"""No model's probability is made smaller than this share of itself by one measurement."""
EXCHANGE_S = 1.0
"""So long after their last exchange, at the next measurement, models exchange their states."""
LEAST_TAKEN = 0.01
"""Of what a model has after an exchange, a smaller share that came from another model is left out: a wide one that
hardly anything speaks for would make the steady one wider at each exchange than its own noise does."""
GOLDEN = 0.618
"""Each new object exchanges so much of that time later than the one before: never many of them in the same ping."""


_Tables = tuple[Floats, Floats, Floats, Floats]
"""Factors, shares, derivatives, times."""


class Model(NamedTuple):
    """A way in which objects move."""

    noise: float
    """Spectral density of the acceleration, m^2/s^3."""
    share: float
    """How often, of all the time, an object moves so."""


class Habits(NamedTuple):
    """How objects change between the ways in which they move."""

    usual: Floats
    """(models,) share of the time that they move in each way."""
    change_rate: float
    """How often they change, 1/s."""


class InteractingModels:
    """See `ods.tracker.observer.horizontal.HorizontalFilter`."""

    def __init__(self, settings: MotionSettings, models: Sequence[Model], change_rate: float = 0.0) -> None:
        """Follow moving objects by `models`, between which they change `change_rate` times a second."""
        self._settings = settings
        self._noise = np.array([model.noise for model in models])
        self._habits = Habits(np.array([model.share for model in models]), change_rate)
        self._filters = TrackTable(each, (1 + len(models), FACTORS))
        self._share = TrackTable(each, (len(models),))
        self._unseen = TrackTable(each, (1 + len(models), UNSEEN, STATE))
        self._apart = TrackTable(each, ())
        """Time since the models exchanged their states, s."""

    def predict(self, dt: float) -> None:
        """Carry all objects on over `dt` >= 0 seconds."""
        motion = self._settings
        noise = motion.static_noise, self._noise, motion.vertical_velocity_sigma
        _predict(self._filters.table, self._unseen.table, dt, noise)

    def state(self) -> HorizontalState:
        """Return where objects are."""
        return HorizontalState(self._share.table, *_places(self._filters.table), self._unseen.table)

    def velocity(self) -> tuple[Floats, Floats]:
        """Return mean and variance (2, n) of the velocity of objects if they move."""
        mean, variance = _velocity(self._filters.table, self._share.table)
        return mean, variance

    def acceleration_noise(self) -> Floats:
        """See `KindsOfMotion`."""
        return np.asarray(self._noise @ self._share.table)

    def steady(self) -> tuple[Floats, Floats]:
        """See `KindsOfMotion`."""
        mean, variance = _velocity(self._filters.table[:2], np.ones((1, len(self._filters))))
        return mean, variance

    def append(self, new: NewPlaces) -> None:
        """Append objects whose velocity is unknown."""
        first, count = len(self._filters), len(new.covariance_ne)
        for table in self.tables():
            table.extend(count)
        tables = self._filters.table, self._share.table, self._unseen.table, self._apart.table
        _start(tables, first, new, self._habits.usual, self._settings.velocity_sigma**2)

    def update(
        self, rows: Indices, measured: PositionMeasurement, since_s: Floats, heights: Named[Heights]
    ) -> Named[Learned]:
        """Take one measurement an object, `since_s` after its last one."""
        tables = self._filters.table, self._share.table, self._unseen.table, self._apart.table
        return Named(Learned, _update(tables, rows, measured, since_s, self._habits, heights.table))

    def rest_there(self, rows: Indices) -> None:
        """Start the static hypothesis anew where the likeliest of the moving ones is now."""
        _rest_there(self._filters.table, self._share.table, self._unseen.table, rows)

    def set_out(self, rows: Indices) -> None:
        """Start the moving hypotheses anew where the static one is, with unknown velocity."""
        self._share.table[:, rows] = self._habits.usual[:, None]
        _set_out(self._filters.table, self._unseen.table, rows, self._settings.velocity_sigma**2)

    def join(self, heirs: Indices, old: Indices) -> None:
        """Let the static hypotheses of `heirs` learn where those of `old`, the same objects, were."""
        _join(self._filters.table, self._unseen.table, heirs, old)

    def keep(self, mask: Mask) -> None:
        """Remove the objects where `mask` is False."""
        for table in self.tables():
            table.keep(mask)

    def tables(self) -> list[TrackTable[Any]]:
        """Return all that is known of the objects."""
        return [self._filters, self._share, self._unseen, self._apart]


@kernel
def _start(tables: _Tables, first: int, new: NewPlaces, usual: Floats, velocity_variance: float) -> None:
    """Set objects from `first` on."""
    s, share, unseen, apart = tables
    position, variance = new.position, new.variance
    for k in range(len(new.covariance_ne)):
        i = first + k
        apart[i], share[:, i] = GOLDEN * i % EXCHANGE_S, usual
        place = Place(position[0, k], position[1, k], variance[0, k], variance[1, k], new.covariance_ne[k])
        for h in range(len(s)):
            ud_filter.start(s[h], i, place, 0.0 if h == RESTING else velocity_variance)
            unseen[h, :, :VELOCITY, i] = new.sensitivity[:, :, k]


@kernel
def _predict(s: Floats, unseen: Floats, dt: float, motion: tuple[float, Floats, float]) -> None:
    """Carry all filters on; `motion`: noise at rest, noise of each model, standard deviation of a climb."""
    static_noise, noise, climb = motion
    for i in range(s.shape[2]):
        ud_filter.drift(s[RESTING], i, static_noise * dt)
        for m in range(len(noise)):
            ud_filter.predict(s[1 + m], i, dt, noise[m])
    for m in range(len(noise)):
        sensitivity.carry_on(unseen, 1 + m, dt, climb)


@kernel
def _places(s: Floats) -> tuple[Floats, Floats, Floats]:
    """Return position, variance and covariance of `HorizontalState`."""
    hypotheses, _, n = s.shape
    position, variance = np.empty((hypotheses, 2, n)), np.empty((hypotheses, 2, n))
    covariance = np.empty((hypotheses, n))
    for h in range(hypotheses):
        for i in range(n):
            place = ud_filter.place_of(s[h], i)
            position[h, NORTH, i], position[h, EAST, i] = place.north, place.east
            variance[h, NORTH, i], variance[h, EAST, i] = place.variance_north, place.variance_east
            covariance[h, i] = place.covariance_ne
    return position, variance, covariance


@kernel
def _velocity(s: Floats, share: Floats) -> Floats:
    """Return (2, 2, n) mean and variance of the moving hypotheses taken together."""
    n = s.shape[2]
    moments = np.zeros((2, 2, n))
    mean, variance = moments
    for i in range(n):
        for m in range(len(share)):
            for axis in range(2):
                mean[axis, i] += share[m, i] * s[1 + m, VELOCITY + axis, i]
        for m in range(len(share)):
            own = ud_filter.velocity_variances(s[1 + m], i)
            for axis in range(2):
                offset = s[1 + m, VELOCITY + axis, i] - mean[axis, i]
                variance[axis, i] += share[m, i] * (own[axis] + offset**2)
    return moments


@kernel
def _update(
    tables: _Tables,
    rows: Indices,
    measured: PositionMeasurement,
    since_s: Floats,
    habits: Habits,
    height_table: Floats,
) -> Floats:
    """Update all filters of `rows`; return the (5, 2, k) table of `Learned`."""
    s, share, unseen, apart = tables
    models, heights, table = len(share), sensitivity.height_rows(height_table), np.empty((5, 2, len(rows)))
    learned, evidence, by_model = learned_rows(table), np.empty(models), np.empty((4, models))
    step, variance, square, square_variance = learned[1:]
    scratch = scratch_for(models)
    for k, i in enumerate(rows):
        apart[i] += since_s[k]
        if models > 1 and apart[i] >= EXCHANGE_S:
            interact(s, share, unseen, i, habits.usual, math.exp(-habits.change_rate * apart[i]), scratch)
            apart[i] = 0.0
        rest = _correct(s, unseen, RESTING, i, sensitivity.fix_of(measured, k, heights, RESTING), heights.step[0, k])
        moved = sensitivity.fix_of(measured, k, heights, 1)
        for m in range(models):
            told = _correct(s, unseen, 1 + m, i, moved, heights.step[1, k])
            evidence[m], by_model[0, m], by_model[1, m] = told.log_likelihood, told.step, told.variance
            by_model[2, m], by_model[3, m] = told.square, told.square_variance
        learned.log_likelihood[RESTING, k] = rest.log_likelihood
        learned.log_likelihood[1, k] = _weigh(share, i, evidence)
        step[RESTING, k], variance[RESTING, k] = rest.step, rest.variance
        square[RESTING, k], square_variance[RESTING, k] = rest.square, rest.square_variance
        step[1, k], variance[1, k] = _mixed(share, i, by_model[0], by_model[1])
        square[1, k], square_variance[1, k] = _mixed(share, i, by_model[2], by_model[3])
        for h in range(1 + models):
            _lower(s, unseen, h, i, step[min(h, 1), k])
    return table


@inlined
def _correct(s: Floats, unseen: Floats, h: int, i: int, fix: Fix, step: float) -> Innovation:
    """Correct one filter of an object, and its derivatives, whose height the fan changed by `step`.

    Returns what the measurement was to it.
    """
    _lower(s, unseen, h, i, step)
    told = sensitivity.innovation(unseen, h, i, ud_filter.place_of(s[h], i), fix)
    noise = Place(0.0, 0.0, fix.variance_north, fix.variance_east, fix.covariance_ne)
    gain = ud_filter.update(s[h], i, (told.north, told.east), noise)
    sensitivity.correct(unseen, h, i, gain, told, fix)
    return told


@inlined
def _lower(s: Floats, unseen: Floats, h: int, i: int, step: float) -> None:
    """Change the states of a filter as the mean height changes."""
    if step == 0.0:
        return
    by = sensitivity.lowered(unseen, h, i, step)
    for row in range(STATE_ROWS):
        s[h, row, i] += by[row]


@inlined
def _mixed(share: Floats, i: int, mean: Floats, variance: Floats) -> tuple[float, float]:
    """Return mean and variance of the models taken together."""
    middle, spread = 0.0, 0.0
    for m in range(len(share)):
        middle += share[m, i] * mean[m]
    for m in range(len(share)):
        spread += share[m, i] * (variance[m] + (mean[m] - middle) ** 2)
    return middle, spread


@inlined
def _weigh(share: Floats, i: int, evidence: Floats) -> float:
    """Update the probabilities of the models by their log-likelihoods; return that of all together."""
    best: float = evidence.max()
    total = 0.0
    for m in range(len(share)):
        share[m, i] = max(share[m, i] * math.exp(evidence[m] - best), LEAST_PROBABILITY * share[m, i])
        total += share[m, i]
    for m in range(len(share)):
        share[m, i] /= total
    return best + math.log(total)


class Scratch(NamedTuple):
    """What `interact` works in: the models as they were, and the columns of their mixture."""

    old: Floats
    old_unseen: Floats
    before: Floats
    """Shares of the models."""
    work: Work


@kernel
def scratch_for(models: int) -> Scratch:
    """Return scratch for so many models of one object."""
    return Scratch(
        np.empty((models, FACTORS, 1)),
        np.empty((models, UNSEEN, STATE)),
        np.empty(models),
        ud_filter.work_space((STATE_ROWS + 1) * models),
    )


@kernel
def interact(s: Floats, share: Floats, unseen: Floats, i: int, usual: Floats, stay: float, scratch: Scratch) -> None:
    """Let the models of an object exchange states: with probability `stay` it goes on as before, else as `usual`."""
    old, old_unseen, before, work = scratch
    models = len(share)
    _lay_aside(s, share, unseen, i, scratch)
    for to in range(models):
        share[to, i] = stay * before[to] + (1.0 - stay) * usual[to]
        taken = 0.0
        for m in range(models):
            came = before[m] * ((1.0 - stay) * usual[to] + (stay if m == to else 0.0)) / share[to, i]
            work.weight[m] = came if came >= LEAST_TAKEN else 0.0
            taken += work.weight[m]
        for m in range(models):
            came = work.weight[m] / taken
            work.weight[m] = came
            ud_filter.columns(old[m], 0, work, (models + m, models), came)
            for row in range(STATE_ROWS):
                s[1 + to, row, i] += came * old[m, row, 0]
                for c in range(UNSEEN):
                    unseen[1 + to, c, row, i] += came * old_unseen[m, c, row]
        for m in range(models):
            for row in range(STATE_ROWS):
                work.column[row, m] = old[m, row, 0] - s[1 + to, row, i]
        ud_filter.triangular(s[1 + to], i, work, 2 * models, models)


@kernel
def _lay_aside(s: Floats, share: Floats, unseen: Floats, i: int, scratch: Scratch) -> None:
    """Move the models of an object to the scratch, states and derivatives; number by number: slices cost more."""
    for m in range(len(share)):
        scratch.before[m] = share[m, i]
        for row in range(FACTORS):
            scratch.old[m, row, 0] = s[1 + m, row, i]
        for row in range(STATE_ROWS):
            s[1 + m, row, i] = 0.0
            for c in range(UNSEEN):
                scratch.old_unseen[m, c, row] = unseen[1 + m, c, row, i]
                unseen[1 + m, c, row, i] = 0.0


@kernel
def _rest_there(s: Floats, share: Floats, unseen: Floats, rows: Indices) -> None:
    for i in rows:
        likeliest = 1 + int(share[:, i].argmax())
        ud_filter.start(s[RESTING], i, ud_filter.place_of(s[likeliest], i), 0.0)
        unseen[RESTING, :, :VELOCITY, i] = unseen[likeliest, :, :VELOCITY, i]


@kernel
def _set_out(s: Floats, unseen: Floats, rows: Indices, velocity_variance: float) -> None:
    for i in rows:
        for h in range(1, len(s)):
            ud_filter.start(s[h], i, ud_filter.place_of(s[RESTING], i), velocity_variance)
            unseen[h, :, :, i] = unseen[RESTING, :, :, i]


@kernel
def _join(s: Floats, unseen: Floats, heirs: Indices, old: Indices) -> None:
    for heir, before in zip(heirs, old):  # noqa: B905  numba knows no `strict`
        place, own = ud_filter.place_of(s[RESTING], before), unseen[RESTING]
        away = place.north - s[RESTING, NORTH, heir], place.east - s[RESTING, EAST, heir]
        gain = ud_filter.update(s[RESTING], heir, away, place)
        for c in range(UNSEEN):
            north, east = own[c, 0, before] - own[c, 0, heir], own[c, 1, before] - own[c, 1, heir]
            own[c, 0, heir] += gain.north[0] * north + gain.east[0] * east
            own[c, 1, heir] += gain.north[1] * north + gain.east[1] * east
