"""The vehicle that obeys: its limits, its current, and the places between its steps."""

import math
import threading

import numpy as np
import pytest

from ods.base.frames.geometry import euler_from_quat
from ods.sim_sonar.scene.settings import SceneFile, Sphere, VehiclePath
from ods.sim_sonar.scene.timeline import Scene
from ods.sim_sonar.settings import VehicleSettings
from ods.sim_sonar.steered import SteeredVehicle, at_start

DT_S = 0.05


def gone(vehicle: SteeredVehicle, seconds: float) -> SteeredVehicle:
    for _ in range(round(seconds / DT_S)):
        vehicle.step(DT_S)
    return vehicle


def test_it_turns_climbs_and_gains_speed_no_faster_than_it_can() -> None:
    can = VehicleSettings(turn_rate_deg_s=8.0, acceleration_m_s2=0.1, climb_m_s=0.4, turn_acceleration_deg_s2=4.0)
    vehicle = SteeredVehicle(can, at_start(0.0, 1.0, (0.0, 0.0, 20.0)))
    vehicle.obey(math.radians(170.0), 2.5, 10.0)
    way = np.array([state[:8] for state in gone(vehicle, 60.0).way])
    change = np.diff(way, axis=0) / DT_S
    assert np.degrees(change[:, 4]).max() == pytest.approx(8.0)
    assert change[:, 5].max() == pytest.approx(0.1)
    assert change[:, 3].min() == pytest.approx(-0.4)
    assert np.degrees(np.abs(change[:, 6])).max() <= 4.0 + 1e-9
    end = vehicle.way[-1]
    assert (math.degrees(end.heading_rad), end.speed_m_s, end.down_m) == pytest.approx((170.0, 2.5, 10.0), abs=0.05)


def test_it_turns_the_shorter_way() -> None:
    vehicle = SteeredVehicle(VehicleSettings(), at_start(math.radians(170.0), 2.0))
    vehicle.obey(math.radians(-170.0), 2.0, 0.0)
    assert math.degrees(gone(vehicle, 20.0).way[-1].heading_rad) == pytest.approx(190.0, abs=0.1)


def test_it_cannot_stop() -> None:
    vehicle = SteeredVehicle(VehicleSettings(least_m_s=0.8), at_start(0.0, 2.0))
    vehicle.obey(0.0, 0.0, 0.0)
    assert gone(vehicle, 30.0).way[-1].speed_m_s == 0.8


def test_its_circle_has_the_radius_of_speed_over_rate() -> None:
    vehicle = SteeredVehicle(VehicleSettings(turn_acceleration_deg_s2=1000.0), at_start(0.0, 2.0))
    for _ in range(round(36.0 / DT_S)):
        vehicle.obey(vehicle.way[-1].heading_rad + 1.0, 2.0, 0.0)
        vehicle.step(DT_S)
    east = [state.east_m for state in vehicle.way]
    assert max(east) == pytest.approx(2.0 * 2.0 / math.radians(10.0), rel=0.01)
    assert (vehicle.way[-1].north_m, vehicle.way[-1].east_m) == pytest.approx((0.0, 0.0), abs=0.3)


def test_the_current_takes_it_along_and_the_set_heading_stays() -> None:
    vehicle = gone(SteeredVehicle(VehicleSettings(), at_start(0.0, 2.0), current_m_s=(-0.5, 0.25)), 10.0)
    assert vehicle.way[-1].place == pytest.approx((15.0, 2.5, 0.0))
    assert vehicle.way[-1].velocity_ned == pytest.approx((1.5, 0.25, 0.0))


def test_between_its_steps_it_is_where_it_should_be_and_goes_on_straight() -> None:
    vehicle = SteeredVehicle(VehicleSettings(), at_start(0.0, 2.0, (0.0, 0.0, 20.0)), current_m_s=(0.1, 0.2))
    vehicle.obey(1.0, 2.5, 15.0)
    before, after = gone(vehicle, 5.0).way[-2:]
    middle = 0.5 * (before.t_s + after.t_s)
    assert vehicle.position(middle) == pytest.approx(0.5 * (np.array(before.place) + after.place))
    assert vehicle.position(after.t_s) == pytest.approx(np.array(after.place))
    assert vehicle.velocity(middle) == pytest.approx(np.array(after.velocity_ned))
    assert euler_from_quat(vehicle.attitude(middle))[2] == pytest.approx(0.5 * (before.heading_rad + after.heading_rad))
    ahead = vehicle.position(np.array([after.t_s + DT_S, after.t_s + 2.0 * DT_S]))
    assert ahead - after.place == pytest.approx(np.outer([DT_S, 2.0 * DT_S], after.velocity_ned))


def test_a_scene_sees_it_where_it_really_is() -> None:
    sphere = Sphere(name="ball", position_ned=(30.0, 0.0, 20.0), radius_m=1.0)
    file = SceneFile(seed=1, vehicle=VehiclePath(position_ned=(30.0, 0.0, 20.0)), objects=[sphere])
    vehicle = gone(SteeredVehicle(VehicleSettings(), at_start(0.0, 2.0, (0.0, 0.0, 20.0))), 3.0)
    scene = Scene(file, vehicle=vehicle)
    assert scene.head_at(3.0).position_ned == pytest.approx([6.0, 0.0, 20.0])
    with pytest.raises(ValueError, match="ball"):
        Scene(file)


def test_stopped_it_loses_way_below_the_speed_at_which_it_steers_and_drifts() -> None:
    vehicle = SteeredVehicle(VehicleSettings(acceleration_m_s2=0.2), at_start(0.0, 2.0), current_m_s=(0.0, 0.25))
    vehicle.stop()
    assert gone(vehicle, 20.0).way[-1].speed_m_s == 0.0
    assert vehicle.way[-1].place[:2] == pytest.approx((10.0, 5.0), abs=0.06)  # v^2 / 2 a; 0.25 m/s for 20 s
    vehicle.obey(0.0, 2.0, 0.0)
    assert gone(vehicle, 20.0).way[-1].speed_m_s == 2.0


def test_before_its_start_it_went_straight_on() -> None:
    vehicle = SteeredVehicle(VehicleSettings(), at_start(0.0, 2.0, (5.0, 0.0, 20.0)), current_m_s=(0.0, 0.5), kept=8)
    assert vehicle.position(np.array([-20.0, -1.5])) == pytest.approx(np.array([[-35.0, -10.0, 20], [2.0, -0.75, 20]]))
    gone(vehicle, 1.0)
    assert vehicle.velocity(-3.0) == pytest.approx([2.0, 0.5, 0.0])


def test_who_asks_while_it_steps_gets_one_of_its_states() -> None:
    """From another thread, through many steps: places lie on the way, never between two that do not follow."""
    vehicle = SteeredVehicle(VehicleSettings(), at_start(0.0, 2.0), kept=16)
    seen: list[tuple[float, float]] = []
    done = threading.Event()

    def ask() -> None:
        while not done.is_set():
            t_s = vehicle.way[-1].t_s
            seen.append((t_s, float(vehicle.position(t_s)[0])))

    asking = threading.Thread(target=ask)
    asking.start()
    gone(vehicle, 200.0)
    done.set()
    asking.join()
    assert all(north == pytest.approx(2.0 * t_s, abs=1e-6) for t_s, north in seen)
