"""Beams that say nothing of the water, whatever their samples are: saturated ones, and such as receive a source.

Their samples count as missing: no level, gain or background of other beams comes from them, and no echo is found there.
What distinguishes a continuous source (a spoke) from a beam's gain, from a body and from a loud bottom: it raises
a beam over all ranges, as it is added, which shows most where the others are quiet, and new against what the beam was;
it does so in few beams, about one.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Bytes, Mask
from ods.base.clock import NS
from ods.compiled import native
from ods.messages import Ping
from ods.pipeline.image.samples.amplitude import FULL_SCALE, db_a_count

RINGS = 16
"""Parts of the range."""


class DeafBeams(NamedTuple):
    """Beams of a ping that carry no information."""

    codes: Bytes
    """(beams,) uint8 as of `sight.WHYS`: 0 receives, 2 saturated, 4 a source."""
    any: bool


ALL_HEAR = DeafBeams(np.zeros(0, np.uint8), False)


class BeamJudge:
    """Judges ping after ping."""

    def __init__(self) -> None:
        self._gain = np.full((1, RINGS, 0), np.nan, np.float32)
        self._codes = np.zeros(0, np.uint8)
        self._setting: tuple[object, ...] = ()
        self._t_ns = 0

    def judge(self, ping: Ping, frame: AnyArray, first: int, missing: Mask) -> DeafBeams:
        """Return which beams say nothing; frame (beams, samples) from column `first` on, missing as by `no_data`."""
        setting = (
            ping.beams, ping.planes, ping.samples, ping.dr_m, ping.dtype, ping.scale, ping.scale_factor,
            ping.frequency_hz, ping.setting,
        )  # fmt: skip
        if setting != self._setting:
            self._gain = np.full((ping.planes, RINGS, ping.beams // ping.planes), np.nan, np.float32)
            self._codes = np.zeros(ping.beams, np.uint8)
            self._setting = setting
        since_s, self._t_ns = max(ping.t_ns - self._t_ns, 0) / NS, ping.t_ns
        offset = 0.5 if ping.scale == "linear" and ping.dtype != "f4" else 0.0
        deaf = native.judge_beams(
            frame, first, missing, FULL_SCALE[ping.dtype], db_a_count(ping), offset, since_s, self._gain, self._codes
        )
        return DeafBeams(self._codes, deaf)


def without(missing: Mask, deaf: DeafBeams, samples: int) -> Mask:
    """Return what is missing, (beams, samples) as by `no_data`, with all of the beams that say nothing."""
    if not deaf.any:
        return missing
    more = missing.copy() if missing.size else np.zeros((len(deaf.codes), samples), np.bool_)
    more[deaf.codes > 0] = True
    return more
