"""The receiver's gain: the TVG against spreading and absorption, and its errors over range and beam."""

from collections.abc import Sequence

import numpy as np

from ods.base.arrays import Floats
from ods.sim_sonar.receiver.settings import Belt, DropIn, Dropout, ImageLevels, Tvg
from ods.sim_sonar.receiver.speckle.random_field import normal, uniform
from ods.sim_sonar.sonar.model import SonarModel

BEAM_STREAM, CHANCE_STREAM, PLACE_STREAM = 2, 3, 4


def sample_ranges(sonar: SonarModel) -> Floats:
    """Return (samples,) slant ranges, m."""
    return np.asarray(sonar.range0_m + np.arange(sonar.samples) * sonar.dr_m)


def echo_gain_db(ranges: Floats, tvg: Tvg) -> Floats:
    """Return what water and TVG leave of an echo's level at `ranges`, dB: 0 everywhere when the TVG is set right."""
    spreading, absorption = _set(tvg)
    wrong = (spreading - tvg.spreading_db) * np.log10(ranges)
    return np.asarray(wrong + 2.0 * (absorption - tvg.absorption_db_per_m) * ranges)


def noise_gain_db(ranges: Floats, tvg: Tvg) -> Floats:
    """Return how the TVG lifts the noise at `ranges`, dB: 0 at `noise_range_m`, 0 everywhere when that is 0."""
    if tvg.noise_range_m == 0.0:
        return np.zeros(len(ranges))
    spreading, absorption = _set(tvg)
    lift = spreading * np.log10(ranges / tvg.noise_range_m)
    return np.asarray(lift + 2.0 * absorption * (ranges - tvg.noise_range_m))


def belts_db(ranges: Floats, belts: Sequence[Belt]) -> Floats:
    """Return the gain of all belts at `ranges`, dB; edges are sloped evenly about their ranges."""
    total = np.zeros(len(ranges))
    for belt in belts:
        slope = max(belt.edge_m, 1e-6)
        inside = np.minimum(ranges - belt.from_m, belt.to_m - ranges) / slope + 0.5
        total += belt.gain_db * np.clip(inside, 0.0, 1.0)
    return total


def beams_db(sonar: SonarModel, levels: ImageLevels, seed: int) -> Floats:
    """Return (beams,) errors of the beams' gains, dB. Raises ValueError when their number is not the sonar's."""
    given = levels.beam_gain_db
    if given:
        if len(given) != sonar.beams:
            raise ValueError(f"image.beam_gain_db: {len(given)} values for the {sonar.beams} beams of {sonar.name}")
        return np.array(given)
    drawn = [normal(seed, BEAM_STREAM, beam) for beam in range(sonar.beams)]
    return levels.beam_gain_rms_db * np.array(drawn)


def arcs_db(ranges: Floats, arcs: Sequence[Dropout | DropIn], seed: int, ping_number: int) -> Floats:
    """Return the gain of the drop-outs and drop-ins of one ping at `ranges`, dB."""
    total = np.zeros(len(ranges))
    for index, arc in enumerate(arcs):
        place = index, ping_number
        if ping_number not in arc.pings if arc.pings else uniform(seed, CHANCE_STREAM, *place) >= arc.chance:
            continue
        middle = arc.range_m
        if middle is None:
            middle = ranges[0] + uniform(seed, PLACE_STREAM, *place) * (ranges[-1] - ranges[0])
        total[np.abs(ranges - middle) <= 0.5 * arc.width_m] += arc.gain_db
    return total


def _set(tvg: Tvg) -> tuple[float, float]:
    """Return spreading, dB a decade, and absorption, dB/m, that the TVG is set to."""
    spreading = tvg.spreading_db if tvg.set_spreading_db is None else tvg.set_spreading_db
    absorption = tvg.absorption_db_per_m if tvg.set_absorption_db_per_m is None else tvg.set_absorption_db_per_m
    return spreading, absorption
