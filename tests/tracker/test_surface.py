"""Waves of the surface: what runs alike where the surface may be is left out, and never what may be hit."""

from dataclasses import replace

import numpy as np
import pytest

from ods.base.arrays import Floats
from ods.base.clock import NS
from ods.base.frames.geometry import quat_from_euler
from ods.pose.buffer import PoseEstimate
from ods.tracker.existence import lifecycle
from ods.tracker.map.map_object import MapObject
from ods.tracker.output.hittable import ReportableFilter
from ods.tracker.output.snapshot import Snapshot, snapshot_of_map
from ods.tracker.output.surface import View, WaveFilter
from ods.tracker.settings import SurfaceSettings, TrackerSettings

HALF = np.radians(10.0)
RUN = np.array([-1.6, 0.4])
PLACES = np.array([[45.0, -20.0], [60.0, 10.0], [70.0, 25.0], [55.0, -5.0], [80.0, 0.0]])
MORE = np.vstack([PLACES, [[50.0, 15.0], [75.0, -15.0]]])


def seen(places: Floats, velocities: Floats, down: float = 3.0, sigma_down: float = 3.0, at_s: float = 0.0) -> Snapshot:
    """Active objects at (n, 2) places of (n, 2) velocities, seen at `at_s`."""
    count, now = len(places), round(at_s * NS)
    objects = [
        MapObject(k + 1, (n, e, down), (0.2, 0.2, sigma_down), 0.5, 0.1, 0.99, 9, 0, now, now)
        for k, (n, e) in enumerate(places.tolist())
    ]
    whole = snapshot_of_map(objects)
    return replace(
        whole,
        state=np.full(count, lifecycle.ACTIVE),
        velocity=np.vstack([velocities.T, np.zeros(count)]),
        sigma_velocity=np.full((3, count), 0.15),
        static=np.where(np.hypot(*velocities.T) > 0.5, 0.01, 0.99),
    )


def view(depth_m: float = 6.0, at_s: float = 0.0, pitch: float = 0.0) -> View:
    zeros, attitude = np.zeros(3), np.asarray(quat_from_euler(0.0, pitch, 0.0))
    head = PoseEstimate(0, np.array([0.0, 0.0, depth_m]), attitude, zeros, zeros, zeros, 0.0)
    return View(round(at_s * NS), head, HALF)


def alike(count: int, velocity: Floats = RUN) -> Floats:
    return np.tile(velocity, (count, 1))


def test_objects_that_run_alike_under_the_surface_are_waves_and_others_are_not() -> None:
    velocities = np.vstack([alike(5), [[0.0, 0.0], [-0.2, -0.8], [1.6, -0.4]]])
    places = np.vstack([PLACES, [[50.0, 5.0], [65.0, -10.0], [58.0, 12.0]]])
    assert WaveFilter(SurfaceSettings()).among(seen(places, velocities), view()).tolist() == [True] * 5 + [False] * 3


@pytest.mark.parametrize(
    ("places", "velocities", "depth_m", "why"),
    [
        (PLACES[:3], alike(3), 6.0, "three may run alike by chance"),
        (np.array([60.0, 5.0]) + 0.1 * PLACES, alike(5), 6.0, "a school keeps together"),
        (PLACES, alike(5, 0.5 * RUN), 6.0, "slower than any wave that is seen"),
        (PLACES, alike(5), 40.0, "the fan does not reach the surface"),
        (PLACES, alike(5), -1.0, "the sonar is above it, so heights count from elsewhere"),
        (PLACES, RUN * np.array([[1.0], [-1.0], [2.0], [0.0], [0.3]]), 6.0, "they do not run alike"),
    ],
)
def test_what_is_no_field_of_waves(places: Floats, velocities: Floats, depth_m: float, why: str) -> None:
    assert not WaveFilter(SurfaceSettings()).among(seen(places, velocities), view(depth_m)).any(), why


def of_unknown_velocity(count: int, at_s: float = 0.0, seen_s: float | None = None) -> Snapshot:
    """Two that run, and others that may."""
    everything = seen(MORE[:count], np.vstack([alike(2), np.zeros((count - 2, 2))]), at_s=at_s)
    static, sigma, last = everything.static.copy(), everything.sigma_velocity.copy(), everything.last_seen_utc_ns.copy()
    static[2:], sigma[:, 2:] = 0.7, 0.9
    last[:] = round((at_s if seen_s is None else seen_s) * NS)
    return replace(everything, static=static, sigma_velocity=sigma, last_seen_utc_ns=last)


def test_until_it_is_known_whether_they_run_alike_those_that_may_are_not_reported() -> None:
    """In the first seconds a sonar knows the velocities of few waves; a planner is not to receive the others."""
    waves = WaveFilter(SurfaceSettings())

    def left_out(at_s: float, count: int = 5) -> list[bool]:
        found: list[bool] = waves.among(of_unknown_velocity(count, at_s), view(at_s=at_s)).tolist()
        return found

    assert [left_out(at_s) for at_s in (0.0, 2.9, 3.0)] == [[True] * 5, [True] * 5, [False] * 5]
    assert not any(WaveFilter(SurfaceSettings()).among(of_unknown_velocity(3), view())), "too few for waves"
    assert not any(WaveFilter(SurfaceSettings()).among(of_unknown_velocity(7).take(np.arange(2, 7)), view())), (
        "none runs"
    )
    assert waves.among(seen(PLACES, alike(5), at_s=3.1), view(at_s=3.1)).all()
    too_near = replace(of_unknown_velocity(5), position=0.2 * seen(PLACES, alike(5)).position)
    assert not WaveFilter(SurfaceSettings()).among(too_near, view(depth_m=1.0)).any()


def test_what_rests_for_sure_does_not_wait() -> None:
    everything = of_unknown_velocity(5)
    everything.static[4], everything.sigma_velocity[:, 4] = 0.91, 0.6
    assert WaveFilter(SurfaceSettings()).among(everything, view()).tolist() == [True] * 4 + [False]


def test_what_is_not_seen_any_more_waits_until_it_is() -> None:
    """A wave that leaves the fan, before it showed its velocity."""
    waves = WaveFilter(SurfaceSettings())
    assert waves.among(of_unknown_velocity(5), view()).all()
    assert waves.among(of_unknown_velocity(5, 4.0, seen_s=0.0), view(at_s=4.0)).all()
    assert not waves.among(of_unknown_velocity(5, 4.1), view(at_s=4.1)).any()


@pytest.mark.parametrize("down", [1.5, 2.0, 4.0])
def test_what_is_known_to_hang_lower_than_the_clearance_is_never_a_wave(down: float) -> None:
    waves = WaveFilter(SurfaceSettings(clearance_m=1.0))
    everything = seen(PLACES, alike(5))
    assert waves.among(everything, view()).all()
    sure = everything.position.copy(), everything.sigma_position.copy()
    sure[0][2, 1], sure[1][2, 1] = down, 0.2
    keel = replace(everything, position=sure[0], sigma_position=sure[1])
    assert waves.among(keel, view()).tolist() == [True, False, True, True, True]


def test_a_height_says_nothing_where_only_the_sides_of_the_main_lobe_meet_the_surface() -> None:
    """At 6 m depth the main lobe of 10 degrees meets it from 34 m on, its sides of 20 degrees from 16 m on."""
    places = np.vstack([PLACES, [[25.0, 0.0], [40.0, 0.0]]])
    assert WaveFilter(SurfaceSettings()).among(seen(places, alike(7), 6.0, 2.0), view()).tolist() == [False] * 7
    mixed = seen(places, alike(7))
    mixed.position[2, 5:], mixed.sigma_position[2, 5:] = 6.0, 2.0
    assert WaveFilter(SurfaceSettings()).among(mixed, view()).tolist() == [True] * 6 + [False]


def test_where_the_fan_is_below_the_surface_nothing_is_a_wave() -> None:
    """At 6 m, a fan of 10 degrees and twice that for strong echoes: nearer than 6 m / sin 20 degrees."""
    nearest = 6.0 / np.sin(2.0 * HALF)
    places = np.vstack([PLACES, [[nearest - 2.0, 0.0], [nearest + 2.0, 0.0]]])
    assert WaveFilter(SurfaceSettings()).among(seen(places, alike(7)), view()).tolist() == [True] * 5 + [
        False,
        True,
    ]
    # pitched down by 25 degrees the fan does not look at the surface at all
    assert not WaveFilter(SurfaceSettings()).among(seen(places, alike(7)), view(pitch=-float(np.radians(25.0)))).any()


def test_a_wave_stays_one_for_a_moment_and_a_body_does_not_become_one() -> None:
    waves = WaveFilter(SurfaceSettings())
    assert waves.among(seen(PLACES, alike(5)), view()).all()
    stopped = alike(5)
    stopped[2] = 0.0
    assert waves.among(seen(PLACES, stopped, at_s=1.0), view(at_s=1.0)).all()
    assert waves.among(seen(PLACES, stopped, at_s=3.5), view(at_s=3.5)).tolist() == [True, True, False, True, True]
    assert waves.among(seen(PLACES[:1] + 3.0, alike(1), at_s=10.0), view(at_s=10.0)).all()  # the waves are remembered
    assert not waves.among(seen(PLACES[:1] + 9.0, alike(1), at_s=40.0), view(at_s=40.0)).any()


def test_a_wave_that_is_not_seen_again_stays_one_until_the_map_has_it() -> None:
    waves = WaveFilter(SurfaceSettings())
    assert waves.among(seen(PLACES, alike(5)), view()).all()
    resting = alike(5)
    resting[2:] = 0.0
    silent = seen(PLACES, resting, at_s=2.0)
    assert waves.among(silent, view(at_s=2.0)).all()
    assert waves.among(silent, view(at_s=9.0)).all()
    asleep = silent.state.copy()
    asleep[3] = lifecycle.HIBERNATED
    assert waves.among(replace(silent, state=asleep), view(at_s=9.1)).tolist() == [True, True, True, False, True]
    assert waves.among(seen(PLACES, resting, at_s=9.2), view(at_s=9.2)).tolist() == [True, True, False, False, False]


def test_where_there_are_waves_what_may_run_is_reported_after_three_seconds() -> None:
    waves = WaveFilter(SurfaceSettings())
    assert waves.among(seen(PLACES, alike(5)), view()).all()

    def left_out(north: float, at_s: float, static: float = 0.5, sigma: float = 0.15) -> bool:
        places = np.vstack([PLACES, [[north, 5.0]]])
        everything = seen(places, np.vstack([alike(5), [[-0.1, -0.3]]]), at_s=at_s)
        doubted = everything.static.copy()
        doubted[5] = static
        vague = everything.sigma_velocity.copy()
        vague[:, 5] = sigma
        everything = replace(everything, static=doubted, sigma_velocity=vague)
        return bool(waves.among(everything, view(at_s=at_s))[5])

    assert [left_out(50.0, at_s) for at_s in (2.0, 4.9, 5.1)] == [True, True, False]
    waves.among(seen(PLACES, alike(5), at_s=6.0), view(at_s=6.0))
    assert not left_out(15.0, 6.1)  # too near to wait
    waves.among(seen(PLACES, alike(5), at_s=7.0), view(at_s=7.0))
    assert not left_out(50.0, 7.1, static=0.9)
    waves.among(seen(PLACES, alike(5), at_s=8.0), view(at_s=8.0))
    cut_off = [left_out(50.0, at_s, static=0.9, sigma=0.8) for at_s in (8.1, 11.0, 11.2)]  # by the edge of the fan
    assert cut_off == [True, True, False]
    calm = WaveFilter(SurfaceSettings())
    assert not calm.among(seen(PLACES[:1], alike(1)), view()).any()


def test_without_a_pose_or_when_all_is_asked_for_nothing_is_left_out() -> None:
    everything = seen(PLACES, alike(5))
    assert not WaveFilter(SurfaceSettings()).among(everything, None).any()
    assert not WaveFilter(SurfaceSettings(list="all")).among(everything, view()).any()
    assert len(ReportableFilter(TrackerSettings()).of(everything, None, view())) == 0
    none = everything.take(np.zeros(0, np.intp))
    assert len(ReportableFilter(TrackerSettings()).of(none, None, view())) == 0
