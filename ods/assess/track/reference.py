"""The reference: a Kalman filter that knows which echo is whose, and which objects move.

Position and velocity in north and east, together, with the full noise covariance of range and bearing; objects that do
not move are filtered as that. An object is reported from its third echo on, a moving one until it is out of view for
10 s: a tracker that has to find all this out itself cannot be expected to do better.
"""

import numpy as np

from ods.assess.track.case import Case
from ods.assess.track.record import Record
from ods.base.arrays import Floats, Indices, Mask
from ods.tracker.track import lifecycle

ECHOES = 3
KEPT_S = 10.0
"""A moving object is reported so long after it left the view."""
ACCELERATION_NOISE = 0.01
"""Spectral density for moving objects, m^2/s^3."""
VELOCITY_SIGMA = 1.0
"""Of a moving object at its first echo, m/s."""


def follow_reference(case: Case) -> Record:
    """Return the tracks of the filters, all objects in one array; the object's index is its identity."""
    count, moving = case.truth.shape[1], case.moving
    state, covariance = np.zeros((count, 4)), np.zeros((count, 4, 4))
    echoes, last_view = np.zeros(count, int), np.full(count, -np.inf)
    columns = case.scenario.det[:, 0].astype(int)
    rows, spreads, before = [], [], case.scenario.t[0]
    for k, t in enumerate(case.scenario.t.tolist()):
        _predict(state, covariance, t - before, moving)
        before = t
        mine = np.flatnonzero((columns == k) & (case.source >= 0))
        who = case.source[mine]
        place, noise = fixes(case, k, mine)
        new = echoes[who] == 0
        _start(state, covariance, who[new], place[new], noise[new], moving)
        _update(state, covariance, who[~new], place[~new], noise[~new])
        echoes[who] += 1
        last_view[case.in_view[k]] = t
        told = np.flatnonzero((echoes >= ECHOES) & (~moving | (t - last_view <= KEPT_S)))
        rows.append(_rows(k, told, state, case))
        spreads.append(np.column_stack([covariance[told][:, i, j] for i, j in ((0, 0), (1, 1), (0, 1))]))
    return Record(np.concatenate(rows), np.concatenate(spreads), np.full(len(case.scenario.t), np.nan))


def fixes(case: Case, k: int, rows: Indices) -> tuple[Floats, Floats]:
    """Return (m, 2) places and (m, 2, 2) noise of some detections of scan k, with the pose's uncertainty."""
    meta, det = case.scenario.meta, case.scenario.det[rows]
    angle = det[:, 2] + case.scenario.auv_rpy[k, 2]
    ray = np.column_stack([np.cos(angle), np.sin(angle)])
    across = np.column_stack([-ray[:, 1], ray[:, 0]])
    sideways = det[:, 1] ** 2 * (meta.sigma_bearing**2 + meta.pose_sigma_yaw**2)
    noise = meta.sigma_range**2 * ray[:, :, None] * ray[:, None, :]
    noise += sideways[:, None, None] * across[:, :, None] * across[:, None, :]
    noise += meta.pose_sigma_xy**2 * np.eye(2)
    return case.scenario.auv_pos[k, :2] + det[:, 1, None] * ray, noise


def _predict(state: Floats, covariance: Floats, dt: float, moving: Mask) -> None:
    step = np.eye(4)
    step[0, 2] = step[1, 3] = dt
    axis = ACCELERATION_NOISE * np.array([[dt**3 / 3.0, dt**2 / 2.0], [dt**2 / 2.0, dt]])
    state[:] = state @ step.T
    covariance[:] = step @ covariance @ step.T + np.kron(axis, np.eye(2)) * moving[:, None, None]


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


def _rows(k: int, told: Indices, state: Floats, case: Case) -> Floats:
    status = np.where(case.in_view[k, told], lifecycle.ACTIVE, lifecycle.STAND_BY)
    scan, radius = np.full(len(told), k), case.truth[k, told, 6]
    return np.column_stack([scan, told, state[told], radius, status]).astype(np.float64)
