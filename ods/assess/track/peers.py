"""Stone Soup as the peer: the public library's own trackers, put together as its examples do, on the same scenarios.

Kalman filters with constant velocity on range and bearing, one set of settings for all scenarios: `CONFIRMED` echoes
make a track, a time without echo ends it. It has no field of view, no static objects, no map.
"""

import time
from collections.abc import Callable, Iterator
from datetime import datetime, timedelta
from typing import Any

import numpy as np

from ods.assess.track.case import Case
from ods.assess.track.record import Record
from ods.tracker.existence import lifecycle

CONFIRMED = 5
ACCELERATION_NOISE = 0.01
"""Spectral density for all objects, m^2/s^3."""
PEER_SILENT_S = 3.0
MISSED_SIGMAS = 4.0
EPOCH = datetime(2000, 1, 1)


def available() -> bool:
    """Return whether the library is installed."""
    try:
        import stonesoup  # noqa: F401
    except ImportError:
        return False
    return True


def run_peer(case: Case, association: str) -> Record:
    """Run the library's tracker, `association` "GNN" or "JPDA", over a scenario."""
    detector = _Detector(case)
    tracker = _tracker(case, detector, association)
    rows, spreads, cpu_ms = [np.zeros((0, 8))], [np.zeros((0, 3))], []
    names: dict[str, int] = {}
    steps = iter(tracker)
    for k in range(len(case.scenario.t)):
        start = time.process_time()
        _, tracks = next(steps)
        cpu_ms.append(1e3 * (time.process_time() - start))
        for track in tracks:
            north, v_north, east, v_east = np.asarray(track.state.mean, float).ravel()
            covariance = np.asarray(track.state.covar, float)
            identity = names.setdefault(track.id, len(names) + 1)
            rows.append(np.array([[k, identity, north, east, v_north, v_east, 0.0, lifecycle.ACTIVE]]))
            spreads.append(np.array([[covariance[0, 0], covariance[2, 2], covariance[0, 2]]]))
    return Record(np.concatenate(rows), np.concatenate(spreads), np.array(cpu_ms))


class _Detector:
    """Feeds the library one scan after the other."""

    def __init__(self, case: Case) -> None:
        self._case = case

    def __iter__(self) -> Iterator[tuple[datetime, set[Any]]]:
        from stonesoup.models.measurement.nonlinear import CartesianToBearingRange
        from stonesoup.types.detection import Detection

        case, meta = self._case.scenario, self._case.scenario.meta
        noise = np.diag([meta.sigma_bearing**2 + meta.pose_sigma_yaw**2, meta.sigma_range**2 + meta.pose_sigma_xy**2])
        border = np.searchsorted(case.det[:, 0], np.arange(len(case.t) + 1))
        for k, t in enumerate(case.t.tolist()):
            when = EPOCH + timedelta(seconds=t)
            model = CartesianToBearingRange(
                ndim_state=4,
                mapping=(0, 2),
                noise_covar=noise,
                translation_offset=case.auv_pos[k, :2].reshape(2, 1),
                rotation_offset=np.array([[0.0], [0.0], [case.auv_rpy[k, 2]]]),
            )
            yield (
                when,
                {
                    Detection(np.array([[bearing], [distance]]), timestamp=when, measurement_model=model)
                    for distance, bearing in case.det[border[k] : border[k + 1], 1:3].tolist()
                },
            )


def _tracker(case: Case, detector: Any, association: str) -> Any:
    from stonesoup.dataassociator.neighbour import GNNWith2DAssignment
    from stonesoup.dataassociator.probability import JPDA
    from stonesoup.deleter.time import UpdateTimeDeleter
    from stonesoup.hypothesiser.distance import DistanceHypothesiser
    from stonesoup.hypothesiser.probability import PDAHypothesiser
    from stonesoup.initiator.simple import MultiMeasurementInitiator
    from stonesoup.measures import Mahalanobis
    from stonesoup.models.transition.linear import CombinedLinearGaussianTransitionModel, ConstantVelocity
    from stonesoup.predictor.kalman import KalmanPredictor
    from stonesoup.tracker.simple import MultiTargetMixtureTracker, MultiTargetTracker
    from stonesoup.types.state import GaussianState
    from stonesoup.updater.kalman import ExtendedKalmanUpdater

    axis = ConstantVelocity(ACCELERATION_NOISE)
    predictor = KalmanPredictor(CombinedLinearGaussianTransitionModel([axis, axis]))
    updater = ExtendedKalmanUpdater(measurement_model=None)
    nearest = GNNWith2DAssignment(DistanceHypothesiser(predictor, updater, Mahalanobis(), MISSED_SIGMAS))
    deleter = UpdateTimeDeleter(timedelta(seconds=PEER_SILENT_S))
    initiator = MultiMeasurementInitiator(
        prior_state=GaussianState(np.zeros((4, 1)), np.diag([0.0, 1.0, 0.0, 1.0]), timestamp=EPOCH),
        measurement_model=None,
        deleter=UpdateTimeDeleter(timedelta(seconds=1.0)),
        data_associator=nearest,
        updater=updater,
        min_points=CONFIRMED,
    )
    parts = {"initiator": initiator, "deleter": deleter, "detector": detector, "updater": updater}
    if association == "GNN":
        return MultiTargetTracker(**parts, data_associator=nearest)
    meta = case.scenario.meta
    sector_area = meta.half_fov * 2.0 * meta.range_max  # of measurement space: rad m
    density = max(meta.clutter_lambda or 0.0, 0.1) / sector_area
    probable = PDAHypothesiser(predictor, updater, density, prob_detect=min(meta.pd, 0.99), prob_gate=0.999)
    return MultiTargetMixtureTracker(**parts, data_associator=JPDA(probable))


PEERS: dict[str, Callable[[Case], Record]] = {
    "Stone Soup, GNN": lambda case: run_peer(case, "GNN"),
    "Stone Soup, JPDA": lambda case: run_peer(case, "JPDA"),
}
