"""Stages that compare pings know where the sonar's head was, not where the vehicle was."""

from collections import Counter
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from ods.base.frames.mounting import MountingSettings
from ods.messages import Detections, Ping, Pose, Sector
from ods.pipeline import processor, service
from ods.pipeline.settings import PipelineConfig, PipelineSettings
from ods.pose.buffer import PoseEstimate, PoseSettings
from ods.runtime.service import Service
from tests.sonar_link.sonar_samples import make_ping

STILL = (0.0, 0.0, 0.0)


class ChainOverPings:
    """Notes the poses that it is given."""

    over_pings = True
    geometry_changes = 0
    was_prepared = False
    poses: list[PoseEstimate]

    def __init__(self, _settings: PipelineSettings, **_told: object) -> None:
        ChainOverPings.poses = []

    def process(self, ping: Ping, pose: PoseEstimate) -> Detections:
        ChainOverPings.poses.append(pose)
        return Detections(0, 0, ping.t_ns, 0, 0, 1500.0, Sector(0.0, 1.0, 0.0, 1.0, 0.1), [])


def test_a_stage_over_pings_is_given_the_pose_of_the_head(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processor, "Chain", ChainOverPings)
    monkeypatch.setattr(service, "warm_up", lambda _settings: None)
    stub = SimpleNamespace(counters=Counter(), publish=lambda *_: None, log_once=print, overload=str)
    mounting = MountingSettings(position_m=(3.0, 0.0, 0.5), yaw_deg=90.0)
    config = PipelineConfig(pose=PoseSettings(), pipeline=PipelineSettings(), mounting=mounting)
    worker = service.PipelineWorker(cast(Service, stub), config)
    worker.start()
    ping: Any = make_ping(0)
    worker.handle("pose", Pose(0, ping.t_ns, 0, (10.0, 20.0, 5.0), (0.0, 0.0, 0.0, 1.0), STILL, STILL, STILL))
    worker.handle("ping", ping)
    worker.tick()
    (head,) = ChainOverPings.poses  # the vehicle looks south, its sonar to starboard of that: west
    np.testing.assert_allclose(head.position_ned, [7.0, 20.0, 5.5], atol=1e-12)
    np.testing.assert_allclose(np.abs(head.attitude), [np.sqrt(0.5), 0.0, 0.0, np.sqrt(0.5)], atol=1e-12)
    assert head.attitude[0] * head.attitude[3] < 0.0
