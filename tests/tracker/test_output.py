"""What the planner gets: the full picture, what ended, and plain reasons when it is not to be relied on."""

from dataclasses import replace

import msgspec
import numpy as np
import pytest

from ods.base.clock import NS
from ods.base.computer.overload import STARVED
from ods.messages import Health, Obstacle
from ods.tracker.existence import lifecycle
from ods.tracker.map.map_object import MapObject
from ods.tracker.output.obstacle_list import ObstacleLister
from ods.tracker.output.snapshot import Snapshot, map_objects, snapshot_of_map
from ods.tracker.output.validity import InputMonitor
from ods.tracker.settings import BottomSettings, MotionSettings, PlannerSettings, TrackerSettings
from ods.tracker.tracker import Tracker
from tests.tracker.samples import scan

MOTION = MotionSettings()
ROCK = MapObject(7, (50.0, 1.0, 4.0), (0.1, 0.2, 3.0), 1.5, 0.2, 0.9, 12, 100, 200, 300)


def lister(announce_ended: int = 5, shape_sigma: float = 0.0, lead_times_s: tuple[float, ...] = ()) -> ObstacleLister:
    settings = PlannerSettings(announce_ended=announce_ended, shape_sigma=shape_sigma, lead_times_s=lead_times_s)
    return ObstacleLister(settings, MOTION, BottomSettings())


def snapshot(*ids: int) -> Snapshot:
    return snapshot_of_map([msgspec.structs.replace(ROCK, id=i) for i in ids])


def test_an_obstacle_says_all_that_is_known() -> None:
    (obstacle,) = lister().obstacles(snapshot(7))
    assert obstacle == Obstacle(
        id=7,
        state="hibernated",
        position_ned=(50.0, 1.0, 4.0),
        velocity_ned=(0.0, 0.0, 0.0),
        radius_m=1.5,
        sigma_position=(0.1, 0.2, 3.0),
        sigma_velocity=(0.0, 0.0, 0.0),
        sigma_radius=0.2,
        first_seen_utc_ns=100,
        last_seen_utc_ns=200,
        times_seen=12,
        existence=0.9,
    )
    assert map_objects(snapshot(7), 300) == [ROCK]


def test_what_the_sonar_cannot_see_of_a_shape_stays_uncertain() -> None:
    (obstacle,) = lister(shape_sigma=0.2).obstacles(snapshot(7))
    assert obstacle.sigma_position == pytest.approx((np.hypot(0.1, 0.3), np.hypot(0.2, 0.3), 3.0))
    assert obstacle.sigma_radius == pytest.approx(np.hypot(0.2, 0.3))


def test_what_ended_is_said_in_several_lists_unless_it_comes_back() -> None:
    reported = lister(announce_ended=3)
    reported.end(snapshot(1, 2))
    lists = [
        reported.obstacles(snapshot(5)),
        reported.obstacles(snapshot(2, 5)),
        *(reported.obstacles(snapshot(5)) for _ in "ab"),
    ]
    states = [[(o.id, o.state) for o in one if o.id != 5] for one in lists]
    assert states == [
        [(1, "terminated"), (2, "terminated")],
        [(2, "hibernated"), (1, "terminated")],
        [(1, "terminated")],
        [],
    ]


def test_of_too_many_objects_the_nearest_are_taken() -> None:
    many = snapshot(*range(1, 51))
    rng = np.random.default_rng(5)
    many = replace(many, position=rng.uniform(-100.0, 100.0, (3, 50)), radius=rng.uniform(0.0, 5.0, 50))
    centre = np.array([10.0, -20.0, 4.0])
    taken = many.nearest(7, centre)
    edges = [float(np.hypot(*(p[:2] - centre[:2])) - r) for p, r in zip(many.position.T, many.radius, strict=True)]
    assert taken.id.tolist() == sorted(sorted(many.id.tolist(), key=lambda i: edges[i - 1])[:7])
    assert many.nearest(50, centre) is many
    assert len(many.nearest(7, None)) == 7


def test_no_number_that_is_not_finite_gets_out() -> None:
    bad = snapshot(1, 2, 3)
    bad.position[0, 1] = np.nan
    bad.sigma_velocity[1, 2] = np.inf
    reported = lister()
    assert [o.id for o in reported.obstacles(bad)] == [1]
    assert reported.counters == {"obstacle_not_finite": 2}


def test_a_late_joiner_has_the_full_picture_in_one_list() -> None:
    """Active, stand-by and hibernated objects, the far hibernated ones left out, all in any one list."""
    known = [msgspec.structs.replace(ROCK, id=i, position=(north, 0.0, 4.0)) for i, north in ((1, -80.0), (2, 900.0))]
    tracker = Tracker(TrackerSettings(), known, first_id=10)
    for k in range(40):
        rows = [(30.0, 0.0, 1.0)] if k >= 20 else [(30.0, 0.0, 1.0), (60.0, 0.6, 1.0)]
        tracker.step(
            scan(k / 7, np.zeros(3), 0.0 if k < 20 else 0.3, [(r, b - (0.3 if k >= 20 else 0), a) for r, b, a in rows])
        )
    both = tracker.snapshot(within=(np.zeros(3), 150.0))
    assert sorted(zip(both.id.tolist(), both.state.tolist(), strict=True)) == [
        (1, lifecycle.HIBERNATED),
        (10, 1),
        (11, 1),
    ]
    assert sorted(tracker.snapshot().id.tolist()) == [1, 2, 10, 11]
    (obstacle,) = [o for o in lister().obstacles(both) if o.id == 10]
    assert obstacle.times_seen == 40
    assert obstacle.first_seen_utc_ns == 0


def test_a_snapshot_is_carried_on_in_time() -> None:
    now = replace(snapshot(1), static=np.array([0.25]))
    now.velocity[:, 0] = [1.0, -2.0, 0.0]
    now.sigma_velocity[:, 0] = [0.1, 0.0, 0.2]
    later = now.extrapolated(2.0, MOTION)
    np.testing.assert_allclose(later.position[:, 0], [52.0, -3.0, 4.0])
    more = 0.75 * MOTION.acceleration_noise * 2.0**3 / 3.0 + 0.25 * MOTION.static_noise * 2.0
    np.testing.assert_allclose(later.sigma_position[:, 0] ** 2 - more, [0.3**2, 0.2**2, 3.4**2])


def health(process: str, t_s: float, *problems: str, ready: bool = True) -> Health:
    return Health(process, 1, 0, round(t_s * NS), 0, ready, list(problems), {}, {}, {}, {}, 0.0, 0.0)


def why_ended(process: str) -> str:
    return "pipeline.stage: no such stage" if process == "pipeline" else ""


def monitor() -> InputMonitor:
    made = InputMonitor(0, ("sonar", "pipeline", "nav"), why_ended)
    for process in ("sonar", "pipeline", "nav"):
        made.health(health(process, 9.5))
    for t_s in (8.0, 9.5, 9.65, 9.8):
        made.ping(round(t_s * NS))
    made.pose(round(9.99 * NS))
    return made


def test_all_is_well() -> None:
    assert monitor().reasons(10 * NS, pose_known=True) == []


def test_an_empty_list_just_after_the_start_is_not_relied_on() -> None:
    started = monitor()
    started.first_ping_ns = round(9.2 * NS)
    assert started.reasons(10 * NS, pose_known=True) == [
        "the tracker has just started: objects are still being confirmed"
    ]
    started.ping(round(10.3 * NS))
    assert started.reasons(round(10.3 * NS), pose_known=True) == []


@pytest.mark.parametrize(
    ("seconds", "reasons"),
    [
        (10.4, []),
        (10.6, ["no pose for 0.6 s"]),
        (11.1, ["no ping for 1.3 s", "no pose for 1.1 s"]),
        (
            11.6,
            [
                *("no ping for 1.8 s", "no pose for 1.6 s"),
                "sonar: no sign of life for 2.1 s",
                "pipeline: no sign of life for 2.1 s; it ended: pipeline.stage: no such stage",
                "nav: no sign of life for 2.1 s",
            ],
        ),
    ],
)
def test_silence_is_reported(seconds: float, reasons: list[str]) -> None:
    assert monitor().reasons(round(seconds * NS), pose_known=True) == reasons


def test_problems_of_others_are_passed_on() -> None:
    reported = monitor()
    reported.health(health("nav", 9.9, "the INS is silent", "CAN bus off"))
    reported.health(health("sonar", 9.9, ready=False))
    assert reported.reasons(10 * NS, pose_known=True) == [
        "sonar: not ready",
        "nav: the INS is silent",
        "nav: CAN bus off",
    ]


def test_an_overload_is_the_first_reason_also_where_another_process_notices_it_first() -> None:
    reported = monitor()
    reported.health(health("sonar", 10.9, f"no ping for 1.2 s: {STARVED}"))
    assert reported.reasons(round(11.1 * NS), pose_known=True) == [STARVED, "no ping for 1.3 s", "no pose for 1.1 s"]


def test_an_ins_that_is_gone_is_one_reason() -> None:
    reported = monitor()
    reported.health(health("nav", 10.5, "no pose for 0.6 s: no data arrive on the line any more"))
    assert reported.reasons(round(10.6 * NS), pose_known=True) == [
        "nav: no pose for 0.6 s: no data arrive on the line any more"
    ]


def test_a_ping_without_a_pose() -> None:
    assert monitor().reasons(10 * NS, pose_known=False) == ["no pose for the time of the ping"]


def test_before_anything_came() -> None:
    fresh = InputMonitor(10 * NS, ("sonar",), why_ended)
    assert fresh.reasons(10 * NS, pose_known=True) == ["no ping yet", "no pose yet"]
    assert fresh.reasons(13 * NS, pose_known=True)[2:] == ["sonar: no sign of life for 3.0 s"]


@pytest.mark.parametrize("away", ["no ping", "unseen", "no pose"])
def test_a_list_just_after_sight_was_away_is_not_relied_on(away: str) -> None:
    """The sonar was off for a minute, muted, or its pings had no pose: what is in view now is not confirmed yet."""
    long = InputMonitor(0, (), why_ended)
    reported = {}
    for tenth in range(700):
        t_ns, gone = tenth * NS // 10, 20 <= tenth < 620
        long.pose(t_ns)
        if not (gone and away == "no ping"):
            long.ping(t_ns)
            long.observed(t_ns, float(gone and away == "unseen"), "why", pose_known=not (gone and away == "no pose"))
        reported[tenth] = long.reasons(t_ns, pose_known=True)
    back = ["coverage has just returned: objects are still being confirmed"]
    assert (reported[19], reported[620], reported[629], reported[631], reported[699]) == ([], back, back, [], [])


def test_a_gap_of_seconds_is_no_new_view() -> None:
    short = monitor()
    for t_s in (9.8, 12.7):
        short.observed(round(t_s * NS), 0.0, "")
        short.ping(round(t_s * NS))
    short.pose(round(12.7 * NS))
    assert [reason for reason in short.reasons(round(12.7 * NS), pose_known=True) if "sight" in reason] == []


def test_a_tracker_just_started_has_no_full_picture_yet() -> None:
    fresh = InputMonitor(0, (), why_ended)
    reported = []
    for t_s in (1.0, 1.9, 2.1):
        fresh.ping(round(t_s * NS))
        fresh.pose(round(t_s * NS))
        reported.append(len(fresh.reasons(round(t_s * NS), pose_known=True)))
    assert reported == [1, 1, 0]


@pytest.mark.parametrize(("period_s", "told_s"), [(0.07, 1.05), (0.15, 1.05), (0.5, 1.55), (1.0, 3.05)])
def test_lists_of_a_sonar_that_pings_seldom_do_not_flap_and_its_silence_is_reported(
    period_s: float, told_s: float
) -> None:
    """Each ping comes when its last echo is back, and lists go out 20 times a second."""
    seldom = InputMonitor(0, (), why_ended)
    pings = [period_s * k for k in range(round(20.0 / period_s))]
    waiting, reported = list(pings), {}
    for number in range(500):
        t_s = 0.05 * number
        seldom.pose(round(t_s * NS))
        while waiting and waiting[0] + period_s <= t_s:
            seldom.ping(round(waiting.pop(0) * NS))
        reported[t_s] = seldom.reasons(round(t_s * NS), pose_known=True)
    assert not any(reasons for t_s, reasons in reported.items() if 5.0 < t_s < pings[-1] + told_s - 0.1)
    assert all("no ping for" in reasons[0] for t_s, reasons in reported.items() if t_s > pings[-1] + told_s)


def test_an_object_seen_by_a_sonar_that_pings_seldom_has_three_pings_to_be_confirmed_by() -> None:
    seldom, reported = InputMonitor(0, (), why_ended), []
    for second in range(6):
        seldom.ping(second * NS)
        seldom.pose(second * NS)
        reported.append(bool(seldom.reasons(second * NS, pose_known=True)))
    assert reported == [True, True, True, False, False, False]


def test_an_older_ping_does_not_make_the_newest_one_older() -> None:
    reported = monitor()
    reported.ping(NS)
    reported.pose(NS)
    assert reported.reasons(10 * NS, pose_known=True) == []
