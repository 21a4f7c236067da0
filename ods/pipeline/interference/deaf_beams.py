"""Beams without information, whatever their samples: saturated ones, and those with a continuous source.

Their samples count as missing: no level, gain or background of other beams comes from them, and no echo is found there.
What distinguishes a continuous source (a spoke) from a beam's gain, from a body and from a loud bottom: it raises
a beam over all ranges, as it is added, which shows most where the others are quiet, and new against what the beam was;
it does so in few beams, about one.
"""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Bytes, Mask
from ods.base.clock import NS
from ods.compiled import native
from ods.messages import Ping
from ods.pipeline.image.samples.recorded import Frame

RINGS = 16
"""Parts of the range."""
LEARNING_S, FORGETTING_S = 10.0, 600.0
"""Time constants of what is usual: while nothing is wrong, and while something is."""


class DeafBeams(NamedTuple):
    """Beams of a ping that carry no information."""

    codes: Bytes
    """(beams,) uint8 as of `sight.WHYS`: 0 receives, 2 saturated, 4 a source."""
    any: bool
    missing: Mask
    """(beams, samples) what is missing, as by `no_data`, with all of these beams."""


class BeamJudge:
    """Judges ping after ping."""

    def __init__(self) -> None:
        self._gain = np.zeros((0, RINGS, 0), np.float32)
        self._codes = np.zeros(0, np.uint8)
        self._setting: tuple[object, ...] = ()
        self._t_ns = 0

    def judge(self, ping: Ping, frame: Frame, first: int) -> DeafBeams:
        """Return which beams say nothing, from column `first` on."""
        setting = (
            ping.beams, ping.planes, ping.samples, ping.dr_m, ping.dtype, ping.scale, ping.scale_factor,
            ping.frequency_hz, ping.setting,
        )  # fmt: skip
        if setting != self._setting:
            self._gain = np.full((ping.planes, RINGS, ping.beams // ping.planes), np.nan, np.float32)
            self._codes = np.zeros(ping.beams, np.uint8)
            self._setting = setting
        since_s, self._t_ns = max(ping.t_ns - self._t_ns, 0) / NS, ping.t_ns
        samples, scale, missing, _ = frame
        times_s = since_s, LEARNING_S, FORGETTING_S
        meaning = scale.top, scale.db_a_count
        if not native.judge_beams(samples, first, missing, meaning, times_s, self._gain, self._codes):
            return DeafBeams(self._codes, False, missing)
        more = missing.copy() if missing.size else np.zeros(samples.shape, np.bool_)
        more[self._codes > 0] = True
        return DeafBeams(self._codes, True, more)
