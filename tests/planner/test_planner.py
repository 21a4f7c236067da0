"""What the planner makes of lists, clearance and silence."""

import math

import msgspec
import pytest

from ods.base.clock import NS
from ods.messages import PoseAt
from ods.planner.planner import Planner, SetPoint
from ods.planner.settings import SteeringSettings
from ods.sim_sonar.settings import VehicleSettings
from ods.sim_sonar.steered import SteeredVehicle, at_start
from tests.planner.lists import PERIOD_S, clear, obstacle, pose, reported, steered

GOAL = (200.0, 0.0, 20.0)


def planner(**settings: object) -> Planner:
    made = Planner(SteeringSettings(**settings), [GOAL])  # type: ignore[arg-type]
    made.receive(reported(pose(0.0, 0.0)), clear(pose(0.0, 0.0)))
    made.steer(-NS)
    return made


def straight_on(set_point: SetPoint) -> tuple[float, float, bool, bool]:
    """Return the rest of a set point whose heading is north."""
    assert set_point.heading_rad == pytest.approx(0.0)
    return set_point[1:5]


def test_with_nothing_in_the_way_it_goes_to_the_goal_at_cruise_speed() -> None:
    assert straight_on(steered(planner())) == (2.0, 20.0, False, True)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_it_passes_on_the_nearer_side(side: float) -> None:
    set_point = steered(planner(), obstacle(40.0, 2.0 * side))
    assert set_point.avoiding
    assert 0.0 < -side * set_point.heading_rad < math.radians(40.0)


@pytest.mark.parametrize(("from_m", "side"), [(-13.0, -1.0), (-17.0, 1.0)])
def test_it_passes_behind_what_is_through_first_and_before_what_is_late(from_m: float, side: float) -> None:
    set_point = steered(planner(), obstacle(30.0, from_m, velocity_ned=(0.0, 1.0, 0.0)))
    assert set_point.avoiding
    assert side * set_point.heading_rad > 0.0


def test_where_it_cannot_turn_in_time_it_lets_what_crosses_pass() -> None:
    set_point = steered(planner(turn_rate_deg_s=0.5), obstacle(30.0, -15.0, velocity_ned=(0.0, 1.0, 0.0)))
    assert (set_point.avoiding, set_point.speed_m_s) == (True, 1.0)


def test_it_holds_its_way_against_a_current_across() -> None:
    """A quarter of its speed: it is set off once, until it knows."""
    made = Planner(SteeringSettings(), [GOAL])
    vehicle = SteeredVehicle(VehicleSettings(), at_start(0.0, 1.0, (0.0, 0.0, 20.0)), current_m_s=(0.0, 0.5))
    vehicle.step(PERIOD_S)
    for _ in range(400):
        state = vehicle.way[-1]
        zero = (0.0, 0.0, 0.0)
        here = PoseAt(state.place, state.attitude, state.velocity_ned, zero, zero)
        made.receive(reported(here, t_s=state.t_s), clear(here))
        set_point = made.steer(round(state.t_s * NS))
        vehicle.obey(set_point.heading_rad, set_point.speed_m_s, set_point.down_m)
        vehicle.step(PERIOD_S)
    assert max(abs(state.east_m) for state in vehicle.way) < 4.6
    last = vehicle.way[-1]
    assert math.degrees(math.atan2(last.velocity_ned[1], last.velocity_ned[0])) == pytest.approx(0.0, abs=4.0)


def test_it_goes_from_way_point_to_way_point_and_arrives() -> None:
    made = Planner(SteeringSettings(), [(0.0, 3.0, 10.0), (0.0, 100.0, 12.0)])
    made.receive(reported(pose(0.0, 0.0)), clear(pose(0.0, 0.0)))
    set_point = made.steer(0)
    assert (set_point.down_m, set_point.arrived) == (12.0, False)
    assert set_point.heading_rad == pytest.approx(math.pi / 2.0, abs=0.25)
    made.receive(reported(pose(0.0, 98.0)), clear(pose(0.0, 98.0)))
    assert made.steer(NS // 10).arrived


def test_before_water_that_is_not_known_it_goes_slowly_and_turns_to_what_is_known() -> None:
    here = pose(0.0, 0.0)
    nothing = planner()
    nothing.receive(reported(here), clear(here, 0.0))
    assert nothing.steer(0).speed_m_s == 1.0
    to_starboard = planner()
    to_starboard.receive(reported(here), clear(here, [100.0 if 4 <= k < 18 else 0.0 for k in range(72)]))
    set_point = to_starboard.steer(0)
    assert math.radians(10.0) < set_point.heading_rad < math.radians(100.0)
    forgotten = planner()
    forgotten.receive(reported(here), clear(here, valid=False))
    assert forgotten.steer(0).speed_m_s == 1.0
    without = planner()
    without.receive(reported(here), None)
    assert without.steer(0).speed_m_s == 1.0


def test_an_echo_that_nobody_has_confirmed_is_gone_round() -> None:
    """It is in no list, but ends the clear water, 4 m ahead."""
    here, made = pose(0.0, 0.0), planner()
    ahead = [k in (0, 1, 2, 69, 70, 71) for k in range(72)]
    water = clear(here, [3.0 if near else 100.0 for near in ahead])
    made.receive(reported(here), msgspec.structs.replace(water, nearest_m=[4.0 if near else None for near in ahead]))
    assert abs(made.steer(0).heading_rad) > math.radians(10.0)


def test_it_turns_round_to_a_goal_behind_through_water_that_is_not_known() -> None:
    made = Planner(SteeringSettings(), [(-30.0, 10.0, 20.0)])
    here = pose(0.0, 0.0)
    made.receive(reported(here), clear(here, [60.0 if k < 9 or k >= 63 else 0.0 for k in range(72)]))
    assert abs(made.steer(0).heading_rad) > math.radians(120.0)


def not_valid(made: Planner, at_s: float, *obstacles_at: float) -> SetPoint:
    here = pose(0.0, 0.0)
    obstacles = [obstacle(north, 1.0) for north in obstacles_at]
    made.receive(reported(here, *obstacles, t_s=at_s, valid=False), clear(here, 0.0, valid=False))
    return made.steer(round(at_s * NS))


def test_a_list_that_is_not_valid_slows_it_at_once_and_is_avoided_all_the_same() -> None:
    set_point = not_valid(planner(), 0.2, 20.0)
    assert (set_point.speed_m_s, set_point.valid, set_point.avoiding) == (1.0, False, True)
    assert set_point.down_m == 20.0
    assert set_point.heading_rad != pytest.approx(0.0)


def test_after_a_while_it_climbs_and_comes_back_once_the_list_is_valid() -> None:
    made = planner(not_valid="climb", climb_to_m=6.0)
    assert not_valid(made, 2.5).down_m == 20.0
    assert not_valid(made, 3.5).down_m == 6.0
    made.receive(reported(pose(0.0, 0.0), t_s=4.0), clear(pose(0.0, 0.0)))
    assert straight_on(made.steer(4 * NS)) == (2.0, 20.0, False, True)


def test_after_a_while_it_turns_back() -> None:
    made = planner(not_valid="turn")
    assert not_valid(made, 2.5).heading_rad == pytest.approx(0.0)
    assert abs(not_valid(made, 3.5).heading_rad) == pytest.approx(math.pi)
    assert not_valid(made, 3.7).down_m == 20.0


def test_a_list_that_never_was_valid_makes_it_climb_too() -> None:
    made = Planner(SteeringSettings(), [GOAL])
    assert not_valid(made, 0.0).down_m == 20.0
    assert not_valid(made, 3.5).down_m == 5.0


def test_slow_stays_slow() -> None:
    made = planner(not_valid="slow")
    assert straight_on(not_valid(made, 30.0)) == (1.0, 20.0, False, False)


def test_silence_is_as_a_list_that_is_not_valid() -> None:
    made = planner()
    assert steered(made).valid
    assert made.steer(NS // 2).valid
    late = made.steer(2 * NS)
    assert (late.valid, late.speed_m_s, late.down_m) == (False, 1.0, 20.0)
    assert made.steer(4 * NS).down_m == 5.0, "it climbs"


def test_without_any_list_it_keeps_its_heading_slowly() -> None:
    made = Planner(SteeringSettings(), [GOAL], heading_rad=1.0)
    assert made.steer(0) == SetPoint(1.0, 1.0, 20.0, valid=False)


def test_it_finds_the_way_out_of_a_ring_where_no_heading_keeps_the_distance() -> None:
    """Obstacles 15 m around it, 5 m apart, with one gap of 15 m to starboard."""
    angles = [math.radians(degrees) for degrees in range(0, 360, 20) if degrees not in (80, 100)]
    ring = [(15.0 * math.cos(angle), 15.0 * math.sin(angle)) for angle in angles]
    made, vehicle, nearest = (
        planner(),
        SteeredVehicle(VehicleSettings(), at_start(0.0, 1.0, (0.0, 0.0, 20.0))),
        math.inf,
    )
    for _ in range(150):
        state = vehicle.way[-1]
        here = pose(state.north_m, state.east_m, state.heading_rad, state.speed_m_s)
        made.receive(reported(here, *(obstacle(*place) for place in ring), t_s=state.t_s), clear(here))
        set_point = made.steer(round(state.t_s * NS))
        vehicle.obey(set_point.heading_rad, set_point.speed_m_s, set_point.down_m)
        vehicle.step(PERIOD_S)
        nearest = min(nearest, *(math.dist(place, vehicle.way[-1].place[:2]) for place in ring))
    assert nearest > 1.0 + 0.5
    assert math.hypot(*vehicle.way[-1].place[:2]) > 20.0


@pytest.mark.parametrize(
    ("settings", "told_"),
    [({"slow_m_s": 3.0}, "slow_m_s"), ({"certain_s": 12.0}, "expected_s"), ({"expected_s": 60.0}, "expected_s")],
)
def test_settings_that_contradict_each_other_name_their_key(settings: dict[str, float], told_: str) -> None:
    with pytest.raises(ValueError, match=told_):
        SteeringSettings(**settings)  # type: ignore[arg-type]
