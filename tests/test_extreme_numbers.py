"""Numbers that are absurd but numbers: refused where a message is decoded, or harmless; no warning, no NaN out."""

import warnings
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings, strategies as st

from ods.base import clock
from ods.base.computer.overload import OVERLOADED
from ods.base.geodesy import SiteSettings
from ods.messages import Clearance, Detections, ObstacleList, Ping, Pose
from ods.pipeline.chain import Chain
from ods.pipeline.prepared.plan import PingError
from ods.pipeline.settings import PipelineSettings
from ods.pose.buffer import PoseBuffer, PoseSettings
from ods.runtime.processes import PROCESSES
from ods.tracker.service import TrackerWorker
from ods.tracker.settings import TrackerProcessConfig, TrackerSettings

EXTREMES = [0.0, -0.0, 5e-324, 1e-9, 0.1, 1.0, 6.3, 100.0, 1e4, 1e5, 1e7, 1e9, 1e19, 1e300, 1.7e308]
numbers = st.sampled_from([sign * value for value in EXTREMES for sign in (1.0, -1.0)]) | st.floats()
instants = st.sampled_from([0, 1, -1, 2**62, -(2**62), 2**63 - 1, -(2**63), 2**63, 2**64 - 1])


@pytest.fixture(autouse=True)
def _warnings_are_errors() -> Iterator[None]:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def sent(message: dict[str, Any], kind: type[msgspec.Struct]) -> Any:
    """Return what comes out of the bus: None when it is refused there."""
    try:
        return msgspec.msgpack.decode(msgspec.msgpack.encode(message), type=kind)
    except msgspec.ValidationError:
        return None


def finite(value: Any) -> bool:
    """Tell whether there is not a number in a message, or any part of one, that is not finite."""
    if isinstance(value, float):
        return bool(np.isfinite(value))
    if isinstance(value, msgspec.Struct):
        return all(finite(part) for part in msgspec.structs.astuple(value))
    return all(finite(part) for part in value) if isinstance(value, list | tuple) else True


PING = {
    "seq": 0, "ping_number": 1, "t_ns": 2, "t_rx_ns": 3, "utc_ns": 4, "beams": 4, "samples": 8, "dtype": "u1",
    "data": bytes(range(32)), "bearing_rad": [-0.3, -0.1, 0.1, 0.3], "range0_m": 0.5, "dr_m": 0.5,
    "sound_speed": 1500.0, "elevation_rad": [0.0] * 4, "beam_width_rad": [0.2] * 4, "frequency_hz": 2e5,
    "scale": "log8", "scale_factor": 40.0,
}  # fmt: skip
POSE = {
    "seq": 0, "t_ns": 10**9, "utc_ns": 0, "position_ned": [1.0, 2.0, 3.0], "attitude": [1.0, 0.0, 0.0, 0.0],
    "velocity_body": [1.0, 0.0, 0.0], "sigma_position_ned": [0.1] * 3, "sigma_attitude": [0.01] * 3,
}  # fmt: skip


@st.composite
def changed(draw: st.DrawFn, message: dict[str, Any]) -> dict[str, Any]:
    """A message with one or two of its numbers replaced."""
    made = dict(message)
    for name in draw(st.lists(st.sampled_from(sorted(message)), min_size=1, max_size=2)):
        value = made[name]
        if isinstance(value, float):
            made[name] = draw(numbers)
        elif isinstance(value, list):
            made[name] = [*value]
            made[name][draw(st.integers(0, len(value) - 1))] = draw(numbers)
        elif name.endswith("_ns"):
            made[name] = draw(instants)
    return made


SECTOR = {
    "range_min_m": 0.5, "range_max_m": 100.0, "bearing_min_rad": -0.8, "bearing_max_rad": 0.8, "half_vertical_rad": 0.2,
}  # fmt: skip
DETECTION = {
    "range_m": 40.0, "bearing_rad": 0.1, "radius_m": 1.0, "peak": 5.0, "mean": 3.0, "snr_db": 14.0, "cells": 20,
    "range_extent_m": 2.0, "bearing_extent_rad": 0.05, "sigma_range_m": 0.1, "sigma_bearing_rad": 0.01,
    "sigma_radius_m": 0.3, "elevation_rad": 0.0,
}  # fmt: skip


@pytest.fixture(scope="module")
def chain() -> Chain:
    return Chain(PipelineSettings(), learnt_cells=1000)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=200)
@given(changed(PING))
def test_pings(chain: Chain, message: dict[str, Any]) -> None:
    ping = sent(message, Ping)
    if ping is None:
        return
    try:
        result = chain.process(ping)
    except PingError:
        return
    assert finite(result)
    assert sent(msgspec.to_builtins(result), Detections) == result


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=200)
@given(st.lists(changed(POSE), min_size=1, max_size=4), st.lists(st.integers(0, 3 * 10**9) | instants, max_size=4))
def test_poses(messages: list[dict[str, Any]], times: list[int]) -> None:
    buffer = PoseBuffer(10, 0.3, 250.0)
    for k, message in enumerate(messages):
        pose = sent(message | ({"t_ns": 10**9 + k * 10**8} if message["t_ns"] == 10**9 else {}), Pose)
        if pose is not None:
            buffer.insert(pose)
    for t_ns in (*times, 10**9, 11 * 10**8):
        found = buffer.at(t_ns)
        if found is not None:
            for array in (found.position_ned, found.attitude, found.velocity_ned, found.sigma_attitude):
                assert np.isfinite(array).all()


@pytest.mark.parametrize(
    ("kind", "message", "change"),
    [
        (Ping, PING, {"range0_m": 1e300}),
        (Ping, PING, {"dr_m": 1e300}),
        (Ping, PING, {"t_ns": 2**64 - 1}),
        (Ping, PING, {"scale_factor": float("nan")}),
        (Pose, POSE, {"t_ns": 2**64 - 1}),
        (Pose, POSE, {"position_ned": [0.0, 1e300, 0.0]}),
        (Pose, POSE, {"velocity_body": [0.0, 0.0, float("inf")]}),
    ],
)
def test_what_cannot_be_is_refused_where_it_is_decoded(
    kind: type[msgspec.Struct], message: dict[str, Any], change: dict[str, Any]
) -> None:
    assert sent(message, kind) is not None
    assert sent(message | change, kind) is None


BUSY_DISK = "the disk of the run folder does not respond"


class TrackerAlone:
    """A tracker's worker without a bus."""

    def __init__(self, folder: Path) -> None:
        self.lists: list[ObstacleList | Clearance] = []
        self.counters: Counter[str] = Counter()
        self.process, self.run_dir = PROCESSES["tracker"], folder
        alone: Any = self
        config = TrackerProcessConfig(
            site=SiteSettings(latitude_deg=57.0, longitude_deg=10.0), pose=PoseSettings(), tracker=TrackerSettings()
        )
        self.worker = TrackerWorker(alone, config)
        self.worker._take_over()

    def overload(self) -> str:
        return ""

    def log_once(self, key: str, text: str) -> None:
        self.counters[key] += BUSY_DISK not in text and OVERLOADED not in text

    def publish(self, _topic: str, message: ObstacleList | Clearance) -> None:
        self.lists.append(message)


@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=15)
@given(
    st.lists(st.tuples(changed(SECTOR) | st.just(SECTOR), changed(DETECTION)), min_size=3, max_size=6),
    st.one_of(st.just(1500.0), numbers),
    st.lists(st.tuples(numbers, numbers), max_size=2),
)
def test_detections(
    tmp_path_factory: pytest.TempPathFactory,
    scans: list[tuple[dict[str, Any], dict[str, Any]]],
    sound_speed: float,
    ranges: list[tuple[float, float]],
) -> None:
    alone = TrackerAlone(tmp_path_factory.mktemp("run"))
    now = clock.monotonic_ns()
    for k in range(-3, 40):
        alone.worker.handle("pose", sent(POSE | {"t_ns": now + k * 10**7 - 4 * 10**8}, Pose))
    for k, (sector, detection) in enumerate(scans):
        t_ns = now + k * 10**7 - 4 * 10**8
        message = {
            "seq": k, "ping_number": k, "t_ns": t_ns, "t_rx_ns": t_ns, "utc_ns": t_ns, "sound_speed": sound_speed,
            "sector": sector, "detections": [DETECTION, DETECTION | {"range_m": 70.0}, detection],
            "processed_ranges_m": ranges,
        }  # fmt: skip
        detections = sent(message, Detections)
        if detections is not None:
            alone.worker._track(detections)
    assert finite(alone.lists)
    assert not alone.counters["checkpoint_failed"]  # but by the disk of a busy computer
