"""The planner's examples in the README work as they stand, with only the run folder replaced."""

import re
import select
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
import zmq

from ods.messages import Obstacle, ObstacleList, PoseAt, SonarAnswer, SonarRequest
from ods.runtime import bus

README = Path(__file__).parents[1] / "README.md"
ALL = re.findall(r"```python\n(.*?)```", README.read_text(), re.DOTALL)
EXAMPLES = [example for example in ALL if "obstacle" in example]
SONAR_EXAMPLES = [example for example in ALL if "sonar" in example and example not in EXAMPLES]
ROCK = Obstacle(
    id=7, state="active", position_ned=(31.5, -2.25, 20.0), velocity_ned=(0.0, 0.0, 0.0), radius_m=1.5,
    sigma_position=(0.1, 0.1, 3.0), sigma_velocity=(0.0, 0.0, 0.0), sigma_radius=0.1, first_seen_utc_ns=0,
    last_seen_utc_ns=0, times_seen=9, existence=1.0,
)  # fmt: skip
NORTHBOUND = PoseAt((0.0, 0.0, 20.0), (1.0, 0.0, 0.0, 0.0), (1.75, 0.0, 0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
"""It is within 5 m of the rock's edge after 14.8 s, looked at once a second."""


@pytest.fixture
def run_dir() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        yield Path(folder)


@pytest.mark.parametrize("example", EXAMPLES, ids=["client", "plain"])
def test_planner_example_prints_the_obstacles(example: str, run_dir: Path) -> None:
    assert "/run/ods" in example
    assert len(example.strip().splitlines()) <= 11
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = bus.Publisher(context, run_dir, "tracker")
    program = example.replace("/run/ods", str(run_dir))
    planner = subprocess.Popen([sys.executable, "-u", "-c", program], stdout=subprocess.PIPE, text=True)
    assert planner.stdout is not None
    try:
        for seq in range(200):
            publisher.publish("obstacles", ObstacleList(seq, seq, 0, 0, 0, True, [], [ROCK], pose=NORTHBOUND))
            if select.select([planner.stdout], [], [], 0.05)[0]:
                break
        assert "31.5, -2.25, 20.0" in planner.stdout.readline()
        if "near_misses" in example:
            assert planner.stdout.readline() == "7 may come within 5 m in 15 s\n"
    finally:
        planner.kill()
        planner.wait()
        publisher.close()
        context.term()


@pytest.mark.parametrize("example", SONAR_EXAMPLES, ids=["client", "plain"])
@pytest.mark.parametrize(
    ("answer", "printed"),
    [
        (SonarAnswer(ok=True, reason="", range_m=50.0), "50.0"),
        (SonarAnswer(ok=False, reason="the sonar refused", range_m=100.0), "the sonar refused"),
    ],
)
def test_sonar_example_prints_the_range_or_the_reason(
    example: str, answer: SonarAnswer, printed: str, run_dir: Path
) -> None:
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    responder = bus.Responder(context, run_dir, "sonar-requests")
    program = example.replace("/run/ods", str(run_dir))
    planner = subprocess.Popen([sys.executable, "-u", "-c", program], stdout=subprocess.PIPE, text=True)
    assert planner.stdout is not None
    try:
        asked: list[tuple[list[bytes], SonarRequest]] = []
        while not asked and planner.poll() is None:
            asked = responder.receive()
        ((peer, request),) = asked
        assert request == SonarRequest(range_m=50.0)
        responder.answer(peer, answer)
        assert planner.stdout.readline() == printed + "\n"
    finally:
        planner.kill()
        planner.wait()
        responder.close()
        context.term()


def test_all_examples_are_there() -> None:
    assert (len(EXAMPLES), len(SONAR_EXAMPLES), len(ALL)) == (2, 2, 4)
