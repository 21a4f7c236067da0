"""The reference: a Kalman filter that knows which echo is whose, how each object moves, and how large each error is.

Position and velocity in north and east, together, with the full noise covariance of range and bearing, also while that
is larger than the sonar's own. An object that rests is filtered as one that rests, one that keeps its velocity without
process noise, and one that manoeuvres with the noise that its own velocity shows at that time: 0 but while it changes.
An object is reported from its third echo on, a moving one until it is out of view for 10 s: a tracker that has to find
all this out itself cannot be expected to do better.
"""

import numpy as np

from ods.assess.track.case import VX, VY, Case
from ods.assess.track.record import Record
from ods.base.arrays import Floats, Indices, Mask
from ods.tracker.existence import lifecycle

ECHOES = 3
KEPT_S = 10.0
"""Time for which a moving object is reported after it left the view, s."""
WINDOW_S = 4.0
"""A velocity changes as much as it does within this time."""
STEADY = 1e-6
"""Changes of a velocity below this are of the truth's rounding, m/s."""
VELOCITY_SIGMA = 1.0
"""Of a moving object at its first echo, m/s."""


def run_reference(case: Case) -> Record:
    """Return the tracks of the filters, all objects in one array; the object's index is its identity."""
    count, moving = case.truth.shape[1], case.moving
    state, covariance = np.zeros((count, 4)), np.zeros((count, 4, 4))
    echoes, last_view = np.zeros(count, int), np.full(count, -np.inf)
    columns = case.scenario.det[:, 0].astype(int)
    acceleration_noise = _acceleration_noise(case)
    rows, spreads, before = [], [], case.scenario.t[0]
    for k, t in enumerate(case.scenario.t.tolist()):
        _predict(state, covariance, t - before, acceleration_noise[k])
        before = t
        mine = np.flatnonzero((columns == k) & (case.source >= 0))
        who = case.source[mine]
        place, noise = fixes(case, k, mine)
        new = echoes[who] == 0
        _start(state, covariance, who[new], place[new], noise[new], moving)
        _update(state, covariance, who[~new], place[~new], noise[~new])
        echoes[who] += 1
        last_view[case.in_view[k]] = t
        listed = np.flatnonzero((echoes >= ECHOES) & (~moving | (t - last_view <= KEPT_S)))
        rows.append(_rows(k, listed, state, case))
        spreads.append(np.column_stack([covariance[listed][:, i, j] for i, j in ((0, 0), (1, 1), (0, 1))]))
    return Record(np.concatenate(rows), np.concatenate(spreads), np.full(len(case.scenario.t), np.nan))


def fixes(case: Case, k: int, rows: Indices) -> tuple[Floats, Floats]:
    """Return (m, 2) places and (m, 2, 2) noise of some detections of scan k, with the pose's uncertainty."""
    meta, det = case.scenario.meta, case.scenario.det[rows]
    angle = det[:, 2] + case.scenario.auv_rpy[k, 2]
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    across = np.column_stack([-ray[:, 1], ray[:, 0]])
    factor = case.noise[k, np.maximum(case.source[rows], 0)] ** 2
    sideways = det[:, 1] ** 2 * (factor * meta.sigma_bearing**2 + meta.pose_sigma_yaw**2)
    noise = (factor * meta.sigma_range**2)[:, None, None] * ray[:, :, None] * ray[:, None, :]
    noise += sideways[:, None, None] * across[:, :, None] * across[:, None, :]
    noise += meta.pose_sigma_xy**2 * np.eye(2)
    return case.scenario.auv_pos[k, :2] + det[:, 1, None] * ray, noise


def _acceleration_noise(case: Case) -> Floats:
    """Return (K, N) spectral densities of the accelerations, m^2/s^3, along each axis, by the objects' true velocities.

    White noise of density q changes a velocity within T by q T, mean square, along each axis.
    """
    t, velocity = case.scenario.t, case.truth[:, :, VX : VY + 1]
    begin = np.searchsorted(t, t - WINDOW_S / 2.0)
    end = np.minimum(np.searchsorted(t, t + WINDOW_S / 2.0), len(t) - 1)
    change = (velocity[end] - velocity[begin]) ** 2
    square = np.where(change > STEADY**2, change, 0.0).sum(axis=2)
    return np.asarray(square / (2.0 * WINDOW_S))


def _predict(state: Floats, covariance: Floats, dt: float, acceleration_noise: Floats) -> None:
    """Carry all objects on; `acceleration_noise`: (N,)."""
    step = np.eye(4)
    step[0, 2] = step[1, 3] = dt
    axis = np.kron([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]], np.eye(2))
    state[:] = state @ step.T
    covariance[:] = step @ covariance @ step.T + axis * acceleration_noise[:, None, None]


def _start(state: Floats, covariance: Floats, who: Indices, place: Floats, noise: Floats, moving: Mask) -> None:
    state[who, :2] = place
    covariance[who, :2, :2] = noise
    covariance[who, 2, 2] = covariance[who, 3, 3] = VELOCITY_SIGMA**2 * moving[who]


def _update(state: Floats, covariance: Floats, who: Indices, place: Floats, noise: Floats) -> None:
    if not len(who):
        return
    prior = covariance[who]
    gain = prior[:, :, :2] @ np.linalg.inv(prior[:, :2, :2] + noise)
    state[who] += (gain @ (place - state[who, :2])[:, :, None])[:, :, 0]
    keep = np.eye(4) - np.concatenate([gain, np.zeros_like(gain)], axis=2)
    covariance[who] = keep @ prior @ keep.swapaxes(1, 2) + gain @ noise @ gain.swapaxes(1, 2)


def _rows(k: int, listed: Indices, state: Floats, case: Case) -> Floats:
    status = np.where(case.in_view[k, listed], lifecycle.ACTIVE, lifecycle.STAND_BY)
    scan, radius = np.full(len(listed), k), case.truth[k, listed, 6]
    return np.column_stack([scan, listed, state[listed], radius, status]).astype(np.float64)
