"""Mounting angles, latency and the object's place by robust least squares, with standard errors that hold.

Errors of successive pings are alike (speckle that hardly changes, an aspect that does), so their number overstates what
is known: standard deviations of range and bearing are taken from the residuals, and grow by the root of the residuals'
correlation time in pings.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares

from ods.base.arrays import Floats, Indices
from ods.base.errors import OdsError
from ods.calibrate.model import Echoes, HeadPoses, Parameters, measurement_residuals
from ods.calibrate.sightings import as_expected, first_guess

LEAST_SIGHTINGS = 40
LEAST_HEADINGS_DEG = 20.0
"""By less than this the object's place takes up any error of yaw."""
ROUNDS = 3
SOFT = 2.0
"""Normalized residual from which on an echo counts less."""
STEPS = Parameters(1.0, 1.0, 1.0, 0.02, 0.02, 0.02, 0.2)
"""Of what size changes are."""
PRIOR = Parameters(1e3, 1e3, 20.0, np.radians(30.0), np.radians(10.0), 0.5, 0.5)
"""Standard deviations about the first guess: all that is known where a recording shows nothing."""
MARGIN_S = 0.6
"""Time around a ping for which poses must be known, s: latency and travel time of sound."""


class Fit(NamedTuple):
    """What came out."""

    parameters: Parameters
    sigma: Parameters
    """Standard errors."""
    sightings: int
    headings_deg: float
    """By how much the vehicle's heading differed between sightings."""
    nearest_m: float
    farthest_m: float
    range_rms_m: float
    bearing_rms: float
    """rad."""


def calibrate(echoes: Echoes, head_poses: HeadPoses, depth_m: float | None = None, depth_sigma_m: float = 0.3) -> Fit:
    """Estimate `Parameters` from detections; `depth_m`: the object's down coordinate, where it is known.

    Raises OdsError, one line, for recordings that show nothing.
    """
    echoes = echoes.take(np.flatnonzero(head_poses.history.knows(echoes.t_s, MARGIN_S)))
    if not len(echoes.ping):
        raise OdsError("no detection has a pose at its time")
    chosen, guess = first_guess(echoes, head_poses)
    prior = guess, PRIOR
    if depth_m is not None:
        prior = guess._replace(down=depth_m), PRIOR._replace(down=depth_sigma_m)
    weights = np.ones(2)
    parameters, sigma = guess._replace(down=prior[0].down), PRIOR
    for _ in range(ROUNDS):
        seen = echoes.take(chosen)
        headings_deg = _checked(seen, head_poses)
        parameters, _ = _solve(seen, head_poses, parameters, prior, weights)
        weights = _weights(seen, head_poses, parameters)
        parameters, sigma = _solve(seen, head_poses, parameters, prior, weights)
        used, chosen = seen, as_expected(echoes, head_poses, parameters)
    along, across = measurement_residuals(used, head_poses, parameters)
    return Fit(
        parameters, sigma, len(used.ping), headings_deg, float(used.range_m.min()), float(used.range_m.max()),
        float(np.sqrt(np.mean(along**2))), float(np.sqrt(np.mean(across**2))),
    )  # fmt: skip


def _checked(seen: Echoes, head_poses: HeadPoses) -> float:
    """Return by how much headings differ, deg. Raises OdsError for too few sightings or headings."""
    if len(seen.ping) < LEAST_SIGHTINGS:
        found = f"only {len(seen.ping)} pings show one object at one place, {LEAST_SIGHTINGS} are needed"
        raise OdsError(f"{found}: is there a fixed object that stands out?")
    headings_deg = _spread_deg(head_poses.history.at(seen.t_s)[1].as_euler("ZYX", degrees=True)[:, 0])
    if headings_deg < LEAST_HEADINGS_DEG:
        raise OdsError(
            f"the object is seen from headings within {headings_deg:.0f} deg only, so any yaw fits: pass it on headings"
            f" that differ by {LEAST_HEADINGS_DEG:.0f} deg at least, better by 180"
        )
    return headings_deg


def _spread_deg(headings: Floats) -> float:
    """Return the smallest sector that holds all headings, deg."""
    ordered = np.sort(headings % 360.0)
    return float(360.0 - np.diff(ordered, append=ordered[0] + 360.0).max())


def _solve(
    seen: Echoes, head_poses: HeadPoses, start: Parameters, prior: tuple[Parameters, Parameters], weights: Floats
) -> tuple[Parameters, Parameters]:
    """Return the best parameters and their standard errors; `weights`: of the claimed sigmas of range and bearing."""
    sigma_range, sigma_bearing = weights[0] * seen.sigma_range, weights[1] * seen.sigma_bearing

    def residuals(values: Floats) -> Floats:
        along, across = measurement_residuals(seen, head_poses, Parameters(*values))
        known = (values - np.array(prior[0])) / np.array(prior[1])
        return np.concatenate([along / sigma_range, across / sigma_bearing, known])

    found = least_squares(residuals, np.array(start), x_scale=np.array(STEPS), loss="soft_l1", f_scale=SOFT)
    # those of `found` are the loss's, and understate
    slopes: Floats = np.asarray(least_squares(residuals, found.x, max_nfev=1).jac)
    covariance = np.linalg.inv(slopes.T @ slopes)
    return Parameters(*found.x.tolist()), Parameters(*np.sqrt(np.diag(covariance)).tolist())


def _weights(seen: Echoes, head_poses: HeadPoses, parameters: Parameters) -> Floats:
    """Return by how much the sigmas of range and of bearing must grow for the residuals to be what they claim."""
    along, across = measurement_residuals(seen, head_poses, parameters)
    normalized = along / seen.sigma_range, across / seen.sigma_bearing
    return np.array([_size(row) * np.sqrt(_correlation_pings(row, seen.ping)) for row in normalized])


def _size(row: Floats) -> float:
    """Return the standard deviation of most of a row: outliers do not count."""
    return max(float(1.4826 * np.median(np.abs(row))), 1e-3)


def _correlation_pings(row: Floats, ping: Indices) -> float:
    """Return 1 + 2 sum of the autocorrelation, up to the first lag at which it is lost in the noise."""
    bounded = np.clip(row / _size(row), -3.0, 3.0)
    series = np.zeros(int(ping[-1] - ping[0]) + 1)
    there = np.zeros_like(series)
    series[ping - ping[0]], there[ping - ping[0]] = bounded, 1.0
    power, total = float(np.mean(bounded**2)), 1.0
    for lag in range(1, len(series) // 4):
        pairs = float(there[:-lag] @ there[lag:])
        share = float(series[:-lag] @ series[lag:]) / pairs / power if pairs >= LEAST_SIGHTINGS / 2 else 0.0
        if share < 2.0 / np.sqrt(len(ping)):
            break
        total += 2.0 * share
    return total
