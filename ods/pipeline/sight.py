"""Coverage: the parts of the sector that a ping did not observe.

A part of the sector is unseen where there are no data, where samples are saturated, where a beam receives a source
(`deaf_beams`), and where the level of all ranges of some beams has fallen far below what it was: a head that is
blocked, or out of the water. What the level was is learnt from the images, slowly, so that it follows what changes
slowly: the depth, the bottom, the water. Unseen is, too, where levels of all ranges jump: noise that drowns what was
audible before it. A level that has risen is believed as slowly as a fallen one is forgotten:
what comes back from a loud spell is where it was.
"""

from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Floats, Ints
from ods.base.clock import NS
from ods.compiled import native
from ods.messages import Ping, Sector, UnseenPart, UnseenWhy
from ods.pipeline.image.fan import beam_borders
from ods.pipeline.image.samples.recorded import Frame
from ods.pipeline.interference.deaf_beams import FORGETTING_S, LEARNING_S, RINGS, DeafBeams

GROUPS = 20
"""Parts of the beams whose levels are compared with what they were, in each of RINGS parts of the range."""
GROWING_USED_S = 60.0
"""Time constant with which a raised level becomes the normal one, s."""
GAP_RINGS = 4 * RINGS
"""Number of rings for which missing data are reported as not observed."""
GAP_SHARE = 0.2
"""Share of a ring's samples that must be missing for that."""
SATURATED_SHARE = 0.5
WHYS: tuple[UnseenWhy, ...] = ("no data", "saturated", "level fallen", "interference", "level risen")
"""Codes 1, 2, 3, 4, 5 of a cell; 0 is seen."""


class Unseen(NamedTuple):
    """Parts that one ping did not observe; see `Detections`."""

    parts: list[UnseenPart]
    share: float
    why: str


class _Levels(NamedTuple):
    """(GROUPS, RINGS) each."""

    now_db: Floats
    """NaN where nothing holds data, or the level is unknown."""
    was_db: Floats
    """NaN where not known."""
    usual_db: Floats
    """The same, but what rises is believed slowly."""
    saturated: Floats
    """Share of the samples."""


class BlindnessMonitor:
    """Judges ping after ping."""

    def __init__(self) -> None:
        empty = np.full((GROUPS, RINGS), np.nan)
        self._levels = _Levels(empty.copy(), empty.copy(), empty.copy(), np.zeros((GROUPS, RINGS)))
        self._fallen, self._risen = np.zeros(GROUPS, np.bool_), np.zeros(GROUPS, np.bool_)
        self._setting: tuple[object, ...] = ()
        self._range_m: tuple[float, float] = (0.0, 0.0)
        self._t_ns = 0

    def judge(self, ping: Ping, frame: Frame, first: int, deaf: DeafBeams) -> Unseen:
        """Return what a ping did not show, from column `first` on."""
        self._keep_reference(ping, first)
        since_s, self._t_ns = max(ping.t_ns - self._t_ns, 0) / NS, ping.t_ns
        scale = frame.scale
        blind = native.judge_levels(
            frame.samples, first, deaf.missing, scale.top, scale.db_a_count, self._levels, SATURATED_SHARE, since_s,
            LEARNING_S, FORGETTING_S, GROWING_USED_S,
            self._fallen, self._risen,
        )  # fmt: skip
        if not blind and not deaf.missing.size:
            return Unseen([], 0.0, "")
        codes = self._codes(ping, first, deaf)
        why = self._why(codes) if codes.any() else ""
        return Unseen(_parts(codes, ping, first), float(np.count_nonzero(codes) / codes.size), why)

    def _keep_reference(self, ping: Ping, first: int) -> None:
        """Begin afresh where levels cannot be compared; carry them over where only the range is another."""
        setting = (ping.beams, ping.planes, ping.dtype, ping.scale, ping.scale_factor, ping.frequency_hz, ping.setting)
        span = ping.range0_m + first * ping.dr_m, ping.range0_m + ping.samples * ping.dr_m
        if setting != self._setting:
            self._levels.was_db[:] = self._levels.usual_db[:] = np.nan
            self._fallen[:] = self._risen[:] = False
        elif span != self._range_m:
            share = (np.arange(RINGS) + 0.5) / RINGS
            old, new = (begin + share * (end - begin) for begin, end in (self._range_m, span))
            for row in (*self._levels.was_db, *self._levels.usual_db):
                row[:] = np.interp(new, old, row)
        self._setting, self._range_m = setting, span

    def _codes(self, ping: Ping, first: int, deaf: DeafBeams) -> Ints:
        """Return (beams of a plane, GAP_RINGS) the codes of `WHYS`; what any plane sees is seen."""
        codes = np.zeros((ping.beams, GAP_RINGS), np.int64)
        group = np.arange(ping.beams) * GROUPS // ping.beams
        ring = np.arange(GAP_RINGS) * RINGS // GAP_RINGS
        codes[self._fallen[group]] = 3
        codes[self._risen[group]] = 5
        codes[(self._levels.saturated > SATURATED_SHARE)[np.ix_(group, ring)]] = 2
        if deaf.missing.size:
            shares = np.empty(codes.shape)
            native.shares_of_gaps(deaf.missing, first, shares)
            codes[shares > GAP_SHARE] = 1
        if deaf.any:
            codes = np.where(deaf.codes[:, None] > 0, deaf.codes[:, None], codes)
        planes: Ints = codes.reshape(ping.planes, -1, GAP_RINGS)
        return np.where(planes.all(axis=0), planes.max(axis=0), 0)

    def _why(self, codes: Ints) -> str:
        """Return in plain words what most of it is."""
        counts = np.bincount(codes.reshape(-1), minlength=len(WHYS) + 1)[1:]
        code, share = int(np.argmax(counts)) + 1, f"{np.count_nonzero(codes) / codes.size:.0%} of the image"
        if code == 1:
            return f"no data in {share}"
        if code == 2:
            return f"{share} saturated"
        if code == 4:
            return f"a continuous source is received in {share}"
        if code == 5:
            rise = np.nanmedian((self._levels.now_db - self._levels.was_db)[self._risen])
            return f"noise {rise:.0f} dB above the earlier levels in {share}: it hides weaker objects"
        fall = np.nanmedian((self._levels.usual_db - self._levels.now_db)[self._fallen])
        return f"levels {fall:.0f} dB below the earlier ones in {share}: head blocked or out of the water?"


def nothing_sent(ping: Ping, frame: AnyArray, first: int, top: float) -> Unseen:
    """Return what is unseen where all samples are alike: all. top: full scale."""
    value = frame[0, first]
    code = 2 if value == top else 1
    codes = np.full((ping.beams // ping.planes, GAP_RINGS), code)
    silent = "the sonar sends nothing (all samples are 0)"
    return Unseen(_parts(codes, ping, first), 1.0, silent if value == 0 else f"all samples are alike ({value})")


def with_parts(unseen: Unseen, parts: list[UnseenPart], why: str, sector: Sector) -> Unseen:
    """Return what is unseen with more small parts, of a sector; why: in plain words."""
    span = (sector.bearing_max_rad - sector.bearing_min_rad) * (sector.range_max_m - sector.range_min_m)
    share = min(unseen.share + area_of(parts) / span, 1.0)
    return Unseen([*unseen.parts, *parts], share, f"{unseen.why}; {why}" if unseen.why else why)


def area_of(parts: Sequence[UnseenPart]) -> float:
    """Return the sum of the parts' areas, rad m."""
    return sum((p.bearing_max_rad - p.bearing_min_rad) * (p.range_max_m - p.range_min_m) for p in parts)


def _parts(codes: Ints, ping: Ping, first: int) -> list[UnseenPart]:
    """Return the unseen parts, neighbouring beams alike put together. codes: (beams of a plane, GAP_RINGS)."""
    beams = len(codes)
    width = ping.beam_width_rad[0] if ping.beam_width_rad else np.radians(1.0)
    borders = beam_borders(np.array(ping.bearing_rad[:beams]), width)
    begin_m = ping.range0_m + (first - 0.5) * ping.dr_m
    ring_m = (ping.samples - first) * ping.dr_m / GAP_RINGS
    changes = np.flatnonzero((codes[1:] != codes[:-1]).any(axis=1)) + 1
    parts = []
    for low, high in zip([0, *changes.tolist()], [*changes.tolist(), beams], strict=True):
        row = codes[low]
        steps = [0, *(np.flatnonzero(np.diff(row)) + 1).tolist(), GAP_RINGS]
        for start, stop in pairwise(steps):
            if row[start]:
                near_m, far_m = max(begin_m + start * ring_m, 0.0), begin_m + stop * ring_m
                why = WHYS[row[start] - 1]
                parts.append(UnseenPart(float(borders[low]), float(borders[high]), near_m, far_m, why))
    return parts
