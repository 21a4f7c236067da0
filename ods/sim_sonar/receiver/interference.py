"""Other sonars: their pulses come in at their own rate, whatever our own transmissions do."""

import numpy as np

from ods.base.arrays import Floats
from ods.base.frames import geometry
from ods.sim_sonar.pose import VehiclePose
from ods.sim_sonar.receiver.settings import Interference
from ods.sim_sonar.sonar.model import SonarModel
from ods.sim_sonar.sonar.patterns import NODES_PER_WIDTH


def beam_weights(sonar: SonarModel, source: Interference, pose: VehiclePose) -> Floats:
    """Return (beams,) how strong each beam receives the source: its horizontal pattern, power, one way."""
    body = geometry.global_to_body(np.array(source.position_ned), *pose)
    _, bearing, _ = geometry.body_to_polar(body)
    offset = geometry.wrap_angle(sonar.bearing_rad - bearing) / sonar.beam_width_rad
    running = sonar.horizontal_cumulative
    place, nodes = offset * NODES_PER_WIDTH + 0.5 * (len(running) - 1), np.arange(len(running))
    rise = np.interp(place + 0.5, nodes, running) - np.interp(place - 0.5, nodes, running)
    return np.asarray(rise * NODES_PER_WIDTH)


def arrivals(sonar: SonarModel, source: Interference, t_s: float) -> Floats:
    """Return (samples,) the share of each sample's time that pulses fill, after a transmission at `t_s`."""
    if not source.from_s <= t_s < source.to_s:
        return np.zeros(sonar.samples)
    if source.period_s == 0.0:
        return np.ones(sonar.samples)
    edges = sonar.range0_m + (np.arange(sonar.samples + 1) - 0.5) * sonar.dr_m
    times = np.asarray(t_s + 2.0 * edges / sonar.sound_speed, np.float64)
    sounding = _sounding_time(times - source.start_s, source.period_s, min(source.pulse_s, source.period_s))
    return np.diff(sounding) * 0.5 * sonar.sound_speed / sonar.dr_m


def _sounding_time(times: Floats, period_s: float, pulse_s: float) -> Floats:
    """Return for how long a source that sounds for `pulse_s` every period has sounded between 0 and `times`, s."""
    whole = np.floor(times / period_s)
    return np.asarray(whole * pulse_s + np.minimum(times - whole * period_s, pulse_s))
