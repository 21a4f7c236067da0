"""For path planners: obstacle lists as they arrive, near misses, requests to the sonar.

from ods.client import Obstacles, near_misses

for obstacle_list in Obstacles("/run/ods"):
    if not obstacle_list.valid:
        print("do not rely on it:", obstacle_list.reasons)
    for obstacle in obstacle_list.obstacles:
        print(obstacle.id, obstacle.state, obstacle.position_ned, obstacle.radius_m)
    for miss in near_misses(obstacle_list, within_m=5.0, horizon_s=60.0):
        print(miss.obstacle.id, "may come within 5 m in", miss.time_s, "s")

Obstacles("tcp://192.168.2.10:5600", key="planner.secret")  # of another computer: docs/hardware/network.md

Sonar("/run/ods").set_range(50.0)
Replay("/run/ods").step()
"""

from ods.client.extrapolation import ExtrapolatedObstacle, at
from ods.client.lists import NoListError, Obstacles
from ods.client.near_misses import NearMiss, near_misses
from ods.client.requests import Replay, ReplayError, Sonar, SonarError, VetoError, Vetoes
from ods.messages import (
    ClosestApproach,
    Obstacle,
    ObstacleList,
    Prediction,
    ReplayAnswer,
    ReplayRequest,
    SonarAnswer,
    SonarRequest,
    UnseenPart,
    Veto,
    VetoRegion,
    VetoRequest,
)

__all__ = [
    "ClosestApproach",
    "ExtrapolatedObstacle",
    "NearMiss",
    "NoListError",
    "Obstacle",
    "ObstacleList",
    "Obstacles",
    "Prediction",
    "Replay",
    "ReplayAnswer",
    "ReplayError",
    "ReplayRequest",
    "Sonar",
    "SonarAnswer",
    "SonarError",
    "SonarRequest",
    "UnseenPart",
    "Veto",
    "VetoError",
    "VetoRegion",
    "VetoRequest",
    "Vetoes",
    "at",
    "near_misses",
]  # fmt: skip
