"""From the area of each sample to the amplitude that the sonar shows: gain, speckle, noise, imperfections."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Image
from ods.compiled import native
from ods.sim_sonar.pose import Transmission
from ods.sim_sonar.receiver import gain
from ods.sim_sonar.receiver.interference import arrivals, beam_weights
from ods.sim_sonar.receiver.settings import DropIn, Dropout, ImageLevels
from ods.sim_sonar.receiver.speckle.random_field import Keys, Normals, bits64, make_keys, normal_table
from ods.sim_sonar.receiver.speckle.speckle import SpeckleField
from ods.sim_sonar.receiver.speckle.speckle_law import (
    TABLE_REACH,
    beam_overlap_correlation,
    frozen_correlation,
    normal_correlation,
    speckle_amplitudes,
)
from ods.sim_sonar.sonar.model import SonarModel

NOISE_STREAM, PING_STREAM = 5, 6


class Levels(NamedTuple):
    """What turns one ping's area into mean power; counts^2, float32."""

    echo: Normals
    """(samples,) of 1 m2."""
    noise: Normals
    """(samples,) of the receiver's noise."""
    received: Normals
    """(sources, beams) of other sonars and loud spells, by beam."""
    arriving: Normals
    """(sources, samples) share of each sample that they fill."""
    over_range: Normals
    """(samples,) amplitude gain of the setting, of belts and arcs, on echo and noise alike."""
    over_beams: Normals
    """(beams,) amplitude gain."""
    saturation: np.float32
    """Highest amplitude that is passed on."""


class Chance(NamedTuple):
    """What turns one ping's mean power into speckle and noise."""

    keys: Keys
    """(beams, samples) of the receiver's noise."""
    salt: np.uint32
    """Makes it another one in each ping."""
    normal: Normals
    """`normal_table`."""
    amplitude: Image
    """`speckle_amplitudes`."""
    frozen: Normals
    """`frozen_correlation`."""
    reach: float
    """`TABLE_REACH`."""


class Receiver:
    """A sonar's receiver. The same seed, ping number and pose give the same bytes, in any order of calls.

    Raises ValueError, naming the key, for levels that do not fit the sonar.
    """

    def __init__(
        self, sonar: SonarModel, levels: ImageLevels, seed: int, *, power_db: float = 0.0, gain_db: float = 0.0
    ) -> None:
        """Prepare tables: a second or less. `power_db` raises the echoes, `gain_db` echoes and noise."""
        self._sonar, self._levels, self._seed = sonar, levels, seed
        self._normal = normal_table()
        law = levels.looks, levels.texture
        self._amplitude, self._frozen = speckle_amplitudes(*law), frozen_correlation(*law)
        self._noise_keys = make_keys(seed, NOISE_STREAM, sonar.beams, sonar.samples)
        self._ranges = gain.sample_ranges(sonar)
        self._echo = _power(gain.echo_gain_db(self._ranges, levels.tvg) + power_db, levels.gain)
        self._noise = _power(gain.noise_gain_db(self._ranges, levels.tvg), levels.noise_counts)
        self._belts_db = gain.belts_db(self._ranges, levels.belts) + gain_db
        self._arcs: list[Dropout | DropIn] = [*levels.dropouts, *levels.drop_ins]
        self._over_range = _amplitude(self._belts_db)
        """Of a ping without arcs."""
        self._over_beams = _amplitude(gain.beams_db(sonar, levels, seed))
        self._field = SpeckleField(
            sonar,
            seed,
            normal_correlation(levels.range_correlation, *law),
            beam_overlap_correlation(sonar, *law)
            if levels.beam_correlation is None
            else normal_correlation(levels.beam_correlation, *law),
            levels.coherence_s,
        )

    def levels_of(self, sent: Transmission) -> Levels:
        """Return the levels of one ping."""
        sources, spells, sonar = self._levels.interference, self._levels.loud_spells, self._sonar
        count = len(sources) + len(spells)
        received, arriving = np.zeros((count, sonar.beams)), np.zeros((count, sonar.samples))
        for index, source in enumerate(sources):
            received[index] = source.level_counts**2 * beam_weights(sonar, source, sent.pose)
            arriving[index] = arrivals(sonar, source, sent.t_s)
        for index, spell in enumerate(spells, len(sources)):
            stop = spell.first_beam + spell.beams if spell.beams else sonar.beams
            received[index, spell.first_beam : stop] = spell.level_counts**2
            arriving[index] = spell.from_s <= sent.t_s < spell.to_s
        over_range = self._over_range
        if self._arcs:
            arcs_db = gain.arcs_db(self._ranges, self._arcs, self._seed, sent.ping_number)
            over_range = _amplitude(self._belts_db + arcs_db)
        return Levels(
            self._echo,
            self._noise,
            received.astype(np.float32),
            arriving.astype(np.float32),
            over_range,
            self._over_beams,
            np.float32(self._levels.saturation_counts),
        )

    def mean_image(self, area: Floats, levels: Levels) -> Image:
        """Return the root mean square amplitude, counts, (beams, samples) float32, of a mean area (beams, samples)."""
        power = self._by_all_ways(area) * levels.echo + levels.noise
        power += levels.received.T @ levels.arriving
        image = np.sqrt(power, out=power).astype(np.float32)
        image *= levels.over_range
        image *= levels.over_beams[:, None]
        return np.minimum(image, levels.saturation, out=image)

    def receive(self, area: Floats, sent: Transmission) -> Image:
        """Return the image of a mean area, m2, (beams, samples) float64: amplitude, counts, (beams, samples) float32.

        Intensity is Gamma distributed about the mean of echo, noise and interference together. The echo's part keeps
        its speckle as long as the pose stays; noise and interference are fresh in each ping.
        """
        levels = self.levels_of(sent)
        if not self._levels.speckle:
            return self.mean_image(area, levels)
        area = self._by_all_ways(area)
        field = self._field.at(sent, area)
        salt = np.uint32(bits64(self._seed, PING_STREAM, sent.ping_number) & 0xFFFFFFFF)
        chance = Chance(self._noise_keys, salt, self._normal, self._amplitude, self._frozen, TABLE_REACH)
        native.receive(area, levels, chance, field)
        return field

    def _by_all_ways(self, area: Floats) -> Floats:
        """Return the area, (beams, samples), with what is received by longer ways."""
        received = area
        for way in self._levels.second_ways:
            later = round(way.longer_m / self._sonar.dr_m)
            received = received.copy() if received is area else received
            received[:, later:] += 10.0 ** (0.1 * way.gain_db) * area[:, : -later or None]
        return received


def _power(level_db: Floats, amplitude: float) -> Normals:
    """Return the power of `amplitude` raised by a level."""
    return np.asarray(amplitude**2 * 10.0 ** (0.1 * level_db), np.float32)


def _amplitude(level_db: Floats) -> Normals:
    return np.asarray(10.0 ** (0.05 * level_db), np.float32)
