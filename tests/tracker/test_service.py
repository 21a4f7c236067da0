"""The tracker process as a process: real ZeroMQ on both sides, played by this test."""

import math
import signal
import time
from collections.abc import Callable, Iterator

import pytest

from ods.base import clock
from ods.base.clock import NS
from ods.messages import ObstacleList
from ods.tracker.map.store import open_map
from ods.tracker.output.validity import AWAY_S
from tests.tracker.played import LISTENING_NS, Chain, good, played, says
from tests.tracker.samples import RANGE_MAX_M

pytestmark = pytest.mark.slow


@pytest.fixture
def chain() -> Iterator[Chain]:
    with played() as made:
        yield made


def test_pings_make_lists_and_silence_makes_reasons(chain: Chain) -> None:
    message = chain.until(good)
    assert message.ping_number >= 0
    assert message.t_rx_ns == message.t_ns + 2 * clock.MS
    assert message.t_rx_ns < message.made_ns < clock.monotonic_ns()
    assert 0 <= message.poses_until <= chain.last_pose
    assert {o.state for o in message.obstacles} == {"active"}
    assert message.obstacles[0].position_ned == pytest.approx((40.0, 0.0, 4.0), abs=0.5)
    approach = message.obstacles[0].cpa
    assert approach is not None
    assert approach.distance_m == pytest.approx(40.0 - message.obstacles[0].radius_m, abs=0.5)

    chain.until(lambda _: any(max(each.clear_to_m) for each in chain.clearances))
    clear = next(each for each in reversed(chain.clearances) if max(each.clear_to_m))
    assert clear.valid
    assert clear.seq in [each.seq for each in chain.lists]
    assert 30.0 < max(clear.clear_to_m) < RANGE_MAX_M  # it looks north, and has two objects before it
    assert clear.clear_to_m[len(clear.clear_to_m) // 2] == 0.0

    chain.pings = False
    silent = chain.until(says("no ping for 1."))
    chain.until(lambda _: not chain.clearances[-1].valid)
    assert max(chain.clearances[-1].clear_to_m) == 0.0
    assert (silent.ping_number, silent.t_rx_ns) == (-1, 0)
    assert len(silent.obstacles) == 2  # the full picture goes on
    first = chain.until(lambda _: True)
    second = chain.until(lambda _: True)
    assert second.t_ns - first.t_ns < clock.NS  # several a second
    chain.pings = True
    chain.until(good)

    chain.poses = False
    blind = chain.until(says("no pose for 0."))
    assert blind.ping_number >= 0
    assert blind.poses_until == chain.last_pose
    assert [o.cpa for o in blind.obstacles] == [None, None]
    chain.until(lambda _: chain.health is not None and "pings_without_reception_pose" in chain.health.counters)
    chain.poses = True
    chain.until(good)

    chain.problems["nav"] = ["the INS is silent"]
    chain.until(says("nav: the INS is silent"))
    chain.problems.clear()
    chain.alive.remove("pipeline")
    chain.until(says("pipeline: no sign of life for 2."))
    assert [later.seq - earlier.seq for earlier, later in zip(chain.lists, chain.lists[1:], strict=False)] == [1] * (
        len(chain.lists) - 1
    )


def test_bearings_are_those_of_the_attitude_at_reception(chain: Chain) -> None:
    """Swinging at up to 20 deg/s; with the attitude at transmission places would be off by 3.1 m and 1 m."""
    chain.echoes = [(95.0, 0.1), (55.0, -0.2)]
    chain.heading = lambda t_s: 0.35 * math.sin(t_s)
    chain.until(good)
    begun = time.monotonic()
    chain.until(lambda _: time.monotonic() > begun + 3.0)
    places = [(r * math.cos(b), r * math.sin(b)) for r, b in chain.echoes]
    for message in filter(good, chain.lists):
        for obstacle in message.obstacles:
            assert min(math.dist(obstacle.position_ned[:2], place) for place in places) < 0.5


def test_bad_detections_are_counted_and_nothing_stops(chain: Chain) -> None:
    chain.until(good)
    now = clock.monotonic_ns()
    chain.detect(1, now - 3600 * clock.NS)
    chain.detect(2, now + 3600 * clock.NS)
    chain.echoes = [(40.0, 0.0), (60.0, 0.3), (float("nan"), 0.0), (-1.0, 0.0)]
    chain.until(lambda _: chain.health is not None and chain.health.counters.get("echoes_bad", 0) > 0)
    assert chain.health is not None
    assert chain.health.counters["detections_late"] >= 1
    assert chain.health.counters["detections_from_future"] == 1
    assert good(chain.until(good))


def test_two_pings_of_one_instant_are_one_look(chain: Chain) -> None:
    chain.until(good)
    chain.pings = False
    sent_ns = clock.monotonic_ns() - LISTENING_NS
    for number in (1000, 1001, 1001):
        chain.detect(number, sent_ns)
        chain.until(lambda _: True)  # all at once, a busy machine may leave out the older ones
    chain.until(lambda _: chain.health is not None and chain.health.counters.get("detections_late", 0) == 2)


@pytest.mark.parametrize(("step_m", "said"), [(20.0, "jumped by 20.0 m"), (3000.0, "jumped by 3000.0 m")])
def test_after_a_step_of_the_pose_no_valid_list_has_an_object_of_before(chain: Chain, step_m: float, said: str) -> None:
    """An INS that takes a fix after a dive: what was seen before lies elsewhere now."""
    old = chain.until(good).obstacles
    chain.place = (step_m, 0.0, 4.0)
    chain.until(says(f"the pose {said}: earlier objects are at wrong positions and are dropped"))
    begun = time.monotonic()
    chain.until(lambda _: time.monotonic() > begun + 5.0)
    valid = [message for message in chain.lists if message.valid and message.ping_number >= 0]
    after = [message for message in valid if message.obstacles[0].id > old[-1].id]
    assert len(after) > 5
    for message in after:
        places = sorted(o.position_ned[0] for o in message.obstacles if o.state == "active")
        assert places == pytest.approx([step_m + 40.0, step_m + 60.0 * math.cos(0.3)], abs=1.0)
    assert valid.index(after[0]) + len(after) == len(valid)  # and none between is valid with what was before
    chain.until(lambda _: chain.health is not None and chain.health.counters.get("pose_jumps", 0) == 1)


def test_after_a_turn_of_the_pose_no_valid_list_has_an_object_of_before(chain: Chain) -> None:
    chain.until(good)
    chain.ins_turned_rad = math.pi
    chain.until(says("the pose turned by 180 deg"))
    begun = time.monotonic()
    chain.until(lambda _: time.monotonic() > begun + 5.0)
    newest = chain.until(lambda message: message.valid)
    assert all(o.position_ned[0] < 0.0 for o in newest.obstacles if o.state == "active")
    for message in chain.lists:
        sides = {o.position_ned[0] > 0.0 for o in message.obstacles if o.state == "active"}
        assert not message.valid or len(sides) == 1


def test_port_and_starboard_that_are_exchanged_at_rest_are_reported_within_a_second(chain: Chain) -> None:
    chain.echoes = [(50.0, -0.2), (58.0, 0.15), (66.0, -0.3), (75.0, 0.25)]
    for _ in range(20):
        chain.until(lambda message: message.valid and len(message.obstacles) == 4)
    chain.echoes = [(range_m, -bearing) for range_m, bearing in chain.echoes]
    begun_ns = clock.monotonic_ns()
    message = chain.until(says("of 4 objects are seen elsewhere at once: port and starboard are exchanged"))
    assert message.t_ns - begun_ns < 1.2 * NS
    chain.until(lambda later: later.t_ns > message.t_ns + 7 * NS)
    assert not any(later.valid for later in chain.lists if later.t_ns >= message.t_ns)  # while it lasts


def test_a_heading_that_drifts_at_rest_is_said_with_its_rate_and_the_list_is_not_valid(chain: Chain) -> None:
    chain.echoes = [(40.0, 0.0), (60.0, 0.3), (30.0, -0.3), (80.0, 0.1)]
    chain.until(lambda m: m.valid and len(m.obstacles) == 4 and min(o.times_seen for o in m.obstacles) > 20)
    chain.ins_drift = math.radians(2.0)
    begun = time.monotonic()
    (reason,) = chain.until(says("static objects seem to turn by 2.")).reasons
    print(f"{reason}, after {time.monotonic() - begun:.1f} s")
    chain.until(lambda _: chain.health is not None and any("seem to turn" in each for each in chain.health.problems))


FIVE = [(40.0, 0.0), (60.0, 0.3), (50.0, -0.3), (80.0, 0.1), (70.0, -0.1)]


def tells(chain: Chain, text: str) -> Callable[[object], bool]:
    """Wait for what the tracker's health says."""
    return lambda _: chain.health is not None and any(text in each for each in chain.health.problems)


def test_poses_that_are_stamped_late_are_said_with_their_latency_in_turns(chain: Chain) -> None:
    chain.echoes = FIVE
    chain.heading = lambda t_s: 0.2 * math.sin(1.5 * t_s)
    chain.ahead_ns = 100 * clock.MS
    chain.until(tells(chain, "ms too late, by the pings' clock"))
    assert chain.health is not None
    (problem,) = chain.health.problems
    assert 80.0 < float(problem.split()[3]) < 120.0, problem


def test_a_wrong_yaw_of_the_head_is_said_under_way(chain: Chain) -> None:
    chain.echoes = FIVE
    chain.north_mps, chain.ins_turned_rad = 2.0, math.radians(3.0)
    chain.until(tells(chain, "sonar.mounting.yaw_deg, or the heading, is "))
    assert chain.lists[-1].valid


def test_ranges_that_are_two_percent_too_long_are_said_under_way(chain: Chain) -> None:
    chain.echoes = FIVE
    chain.north_mps, chain.range_scale = 2.0, 1.02
    chain.until(tells(chain, "too long: is the sound speed right?"))
    assert chain.health is not None
    (problem,) = chain.health.problems
    assert 1.5 < float(problem.split()[2]) < 2.5, problem
    assert chain.lists[-1].valid


def test_a_heading_that_drifts_slowly_under_way_is_said(chain: Chain) -> None:
    chain.echoes = FIVE
    chain.until(lambda m: m.valid and len(m.obstacles) == 5)
    chain.north_mps, chain.ins_drift = 1.0, math.radians(0.2)
    chain.until(tells(chain, "static objects seem to turn by 0."))


def test_poses_from_the_future_do_not_keep_the_others_out(chain: Chain) -> None:
    chain.until(good)
    chain.ahead_ns = 60 * clock.NS
    chain.until(says("no pose for 0."))
    chain.until(lambda _: chain.health is not None and chain.health.counters.get("poses_from_future", 0) > 20)
    chain.ahead_ns = 0
    back = time.monotonic()
    chain.until(good)
    assert time.monotonic() - back < 10.0


def test_the_map_outlives_the_process_and_ids_are_not_used_again(chain: Chain) -> None:
    """A clean stop keeps what rests; after kill -9 the map is as it was, and new objects get new ids."""
    ids = {o.id for o in chain.until(lambda m: good(m) and min(o.times_seen for o in m.obstacles) > 30).obstacles}
    chain.process.send_signal(signal.SIGTERM)
    assert chain.process.wait(10) == 0
    store = open_map(chain.folder / "map.sqlite", 57.0, 10.0)
    assert {o.id for o in store.load()} == ids
    store.close()

    chain.echoes.append((50.0, -0.4))
    chain.start()
    back = chain.until(lambda m: m.valid and [o.state for o in m.obstacles] == ["active"] * 3)
    assert {o.id for o in back.obstacles} > ids
    (new,) = {o.id for o in back.obstacles} - ids
    chain.kill()
    for left in chain.folder.glob("tracker.*-*"):
        left.unlink()
    (chain.folder / "tracker.checkpoint").unlink()  # as if the computer had been started again
    chain.start()
    again = chain.until(lambda m: m.valid and [o.state for o in m.obstacles] == ["active"] * 3)
    assert ids < {o.id for o in again.obstacles}
    assert max(o.id for o in again.obstacles) > new


CHECKPOINT_LAG_S = 1.0
"""The checkpoint that a killed tracker left may be so much older than its last list."""


@pytest.mark.parametrize("map_file", ["map.sqlite", None, "unusable"])
def test_a_killed_tracker_goes_on_with_the_same_objects(map_file: str | None) -> None:
    """With a map, without, and with one that cannot be used; new objects get new ids."""
    with played({"map": {"path": map_file}, "resume_within_s": 300.0}) as chain:
        (chain.folder / "unusable").write_text("rubbish " * 1000)
        before = chain.until(lambda m: good(m) and min(o.times_seen for o in m.obstacles) > 20)
        chain.kill()
        chain.start()
        first = chain.until(lambda m: m.ping_number >= 0)
        away_s = (first.t_ns - before.t_ns) / NS
        assert first.valid or away_s > AWAY_S - CHECKPOINT_LAG_S
        assert _places(first) == pytest.approx(_places(before), abs=0.2)
        assert min(o.times_seen for o in first.obstacles) > 20
        chain.echoes.append((50.0, -0.4))
        later = chain.until(lambda m: m.valid and len(m.obstacles) == 3)
        chain.kill()
        chain.start()
        last = chain.until(lambda m: m.ping_number >= 0)
        assert _places(last) == pytest.approx(_places(later), abs=0.2)
        assert max(_places(last)) > max(_places(first))


def _places(message: ObstacleList) -> dict[int, complex]:
    return {o.id: complex(*o.position_ned[:2]) for o in message.obstacles}


def test_ids_are_given_once_even_if_the_run_folder_could_not_be_written() -> None:
    """Without a map, which keeps them, too."""
    with played({"map": {"path": None}, "resume_within_s": 300.0}) as chain:
        ids = {o.id for o in chain.until(good).obstacles}
        hindrance = chain.folder / "tracker.checkpoint.new"
        hindrance.unlink(missing_ok=True)
        hindrance.mkdir()
        chain.echoes.append((50.0, -0.4))
        (old,) = {o.id for o in chain.until(lambda m: m.valid and len(m.obstacles) == 3).obstacles} - ids
        chain.until(lambda _: chain.health is not None and chain.health.counters.get("checkpoint_failed", 0) > 0)
        chain.kill()
        hindrance.rmdir()
        chain.echoes[-1] = (50.0, 0.4)
        chain.start()
        again = {o.id for o in chain.until(lambda m: m.valid and len(m.obstacles) == 3).obstacles}
        assert ids < again
        assert old not in again


def test_what_a_killed_tracker_left_is_not_believed_blindly(chain: Chain) -> None:
    """Damaged or too old: other ids than before, and it is counted."""
    ids = {o.id for o in chain.until(good).obstacles}
    chain.kill()
    checkpoint = chain.folder / "tracker.checkpoint"
    checkpoint.write_bytes(checkpoint.read_bytes()[:-7])
    chain.start()
    assert not {o.id for o in chain.until(good).obstacles} & ids
    chain.until(lambda _: chain.health is not None)
    assert chain.health is not None
    assert chain.health.counters["checkpoint_unusable"] == 1
    newer = {o.id for o in chain.until(good).obstacles}
    chain.kill()
    chain.settings["resume_within_s"] = 0.0
    chain.start()
    assert not {o.id for o in chain.until(good).obstacles} & (ids | newer)
