"""What speaks for and against the existence of each live object, and what an image adds to that."""

import math
from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.compiled.kernel import inlined, kernel
from ods.tracker.association import front, onset, strength, wander
from ods.tracker.association.strength import Typical, typical_rows
from ods.tracker.settings import EchoSettings, MotionSettings
from ods.tracker.track import existence
from ods.tracker.track.existence import Chain, Rates

FLICKERING = 0.03
"""A place flickers when its chance to show an echo without an object is above this."""


class Doubt(NamedTuple):
    """Of n objects: (n,) each."""

    visible: Floats
    """Probabilities of the states of `existence.Chain`."""
    silent: Floats
    nothing: Floats
    spot: Floats
    first_visible: Floats
    """That it existed after the first echo."""
    hits: Floats
    """Since it was started or recalled: echoes after the first,"""
    looks: Floats
    """images in which there might have been one,"""
    flickers: Floats
    """and how many of these would have had one if there were no object: see `flicker`."""
    strength: Floats
    """Sum over its echoes of what they have over the echoes of nothing, in standard deviations of these,"""
    told: Floats
    """and number of the echoes that tell their strength;"""
    by_strength: Floats
    """the log-likelihood ratio taken of that, and"""
    by_motion: Floats
    """that of its motion, or of its size;"""
    off_squares: Floats
    """sum of squares, m2, of how much its echoes were off their range,"""
    placed: Floats
    """number of those that tell it,"""
    by_wander: Floats
    """and the log-likelihood ratio taken of that;"""
    sharp: Floats
    """how many of its echoes set in sharply,"""
    set_in: Floats
    """of so many that tell it,"""
    by_onset: Floats
    """and the log-likelihood ratio taken of that;"""
    fronts: Floats
    """sum of the log-odds of its last echoes' fronts,"""
    judged: Floats
    """of so many that tell it,"""
    by_front: Floats
    """and the log-likelihood ratio taken of that;"""
    spots: Floats
    """the share of spots at its place that it is judged by."""


class Look(NamedTuple):
    """What an image shows of n objects: (n,) each."""

    llr: Floats
    """Log-likelihood ratio of the echo: of the object, or a false alarm; 0 where there is none."""
    watched: Floats
    """Probability that the sonar looked at the object,"""
    expected: Floats
    """and that a visible object would have given an echo; 0 in a drop-out."""
    strength: Floats
    """Of the echo, dB; 0: none, or not told."""
    off_range: Floats
    """By how much the echo is farther than the object was expected, m; NaN: none, or one that is not all of it and only
    of it, or that tells no strength, and so is not of the chain: how such echoes wander nobody knows beforehand."""
    onset: Floats
    """How slowly such an echo sets in, see `onset`; 0: none, or not told."""
    front: Floats
    """How likely such an echo's front is a body's; 0: none, or not told."""


class AtPlaces(NamedTuple):
    """What echoes of nothing are like at n places."""

    spots: Floats
    """(n,) share of spots, which come and go, among them: see `flicker`."""
    typical: Floats
    """(3, n) table of `strength.Typical`."""


class Unexplained(NamedTuple):
    """What is known of k echoes that no object explains: (k,) each."""

    clutter: Floats
    """False alarms a scan if it had as many everywhere as there."""
    strength: Floats
    """dB; 0: not told."""
    onset: Floats
    """0: not told."""
    front: Floats
    """0: not told."""
    nothing: AtPlaces
    spots_sharp: float
    """Share of the echoes of spots that set in sharply,"""
    spots_front: float
    """and mean of their fronts' log-odds."""


class Spots(NamedTuple):
    """What is known of the echoes of spots."""

    wander_m2: float
    """Mean square of what they wander, m2."""
    sharp: float
    """Share of them that set in sharply."""
    front: float
    """Mean of their fronts' log-odds."""
    crowd: float
    """How much of a crowd they are, from 0 to 1: see `crowd`."""


class Counted(NamedTuple):
    """Of the echoes of tracks that ended as spots."""

    off_squares: float
    """Sum of squares, m2, of how much they were off their range,"""
    placed: float
    """of so many;"""
    sharp: float
    """how many set in sharply"""
    set_in: float
    """of so many;"""
    fronts: float
    """sum of the log-odds of the last ones' fronts,"""
    judged: float
    """of so many."""


class Assumed(NamedTuple):
    """What is taken to be known of bodies and spots."""

    rates: Rates
    detection_probability: float
    static_prior: float
    spots: Spots


def assumed(echo: EchoSettings, motion: MotionSettings, spots: Spots) -> Assumed:
    """Return what the settings say, and what was learned of spots."""
    rates = Rates(echo.silence_rate, echo.return_rate, echo.loss_rate)
    return Assumed(rates, echo.detection_probability, motion.static_prior, spots)


@kernel
def doubt_rows(table: Floats) -> Doubt:
    """Name the rows of a (22, n) table."""
    return Doubt(
        table[0],
        table[1],
        table[2],
        table[3],
        table[4],
        table[5],
        table[6],
        table[7],
        table[8],
        table[9],
        table[10],
        table[11],
        table[12],
        table[13],
        table[14],
        table[15],
        table[16],
        table[17],
        table[18],
        table[19],
        table[20],
        table[21],
    )


@kernel
def look_rows(table: Floats) -> Look:
    """Name the rows of a (7, n) table."""
    return Look(table[0], table[1], table[2], table[3], table[4], table[5], table[6])


@kernel
def begin(table: Floats, first: int, births: float, unknown: Unexplained) -> None:
    """Set objects from `first` on, one an unexplained echo, given births a scan."""
    d, typical = doubt_rows(table), typical_rows(unknown.nothing.typical)
    for k in range(len(unknown.clutter)):
        i, spots = first + k, unknown.nothing.spots[k]
        none = unknown.clutter[k] / (births + unknown.clutter[k])
        chain = Chain(1.0 - none, 0.0, (1.0 - spots) * none, spots * none)
        d.spots[i] = spots
        chain = _by_strength(d, i, chain, unknown.strength[k], typical, k)
        chain = _by_front(d, i, chain, unknown.front[k], unknown.spots_front, False)
        _keep(d, i, _by_onset(d, i, chain, unknown.onset[k], unknown.spots_sharp, False))
        d.first_visible[i] = d.visible[i]


@kernel
def take_image(
    table: Floats,
    seen: tuple[Ints, Mask, Mask],
    look_table: Floats,
    nothing: AtPlaces,
    shape: tuple[Floats, Floats],
    dt: float,
    known: Assumed,
) -> None:
    """Judge by an image, `dt` seconds after the one before.

    `seen`: (n,) echoes so far, this one too, which objects are confirmed, and which had an echo; `shape`: (n,)
    probability that they do not move, and radius, m.
    """
    echoes, confirmed, hit = seen
    static, radius = shape
    d, look, typical = doubt_rows(table), look_rows(look_table), typical_rows(nothing.typical)
    for i in range(len(hit)):
        watched, spots = look.watched[i], nothing.spots[i]
        chain = _by_wander(d, i, _chain(d, i), look.off_range[i], echoes[i], known.spots)
        chain = _by_onset(d, i, chain, look.onset[i], known.spots.sharp, confirmed[i])
        chain = _by_front(d, i, chain, look.front[i], known.spots.front, confirmed[i])
        chain = existence.carried_on(chain, echoes[i], watched, dt, known.rates)
        often = existence.how_often(d.hits[i], d.looks[i], known.detection_probability, known.spots.crowd)
        chain = existence.after_image(chain, hit[i], look.llr[i], look.expected[i], often)
        chain = _by_strength(d, i, chain, look.strength[i], typical, i)
        # confirmed objects are judged by what is known of their places by now
        place = spots if confirmed[i] else d.spots[i]
        moves = existence.evidence_of_motion(static[i], known.static_prior, known.spots.crowd)
        _keep(d, i, _by_motion(d, i, chain, max(moves, existence.evidence_of_size(radius[i])), place))
        looked = 1.0 if hit[i] else watched
        d.hits[i] += hit[i]
        d.looks[i] += looked
        d.flickers[i] += existence.SPOT_SEEN * spots * looked


@inlined
def _chain(d: Doubt, i: int) -> Chain:
    return Chain(d.visible[i], d.silent[i], d.nothing[i], d.spot[i])


@inlined
def _keep(d: Doubt, i: int, chain: Chain) -> None:
    d.visible[i], d.silent[i], d.nothing[i], d.spot[i] = chain


@inlined
def _by_wander(d: Doubt, i: int, chain: Chain, off_range: float, echoes: int, spots: Spots) -> Chain:
    """Judge by how far the echoes wander: see `wander`."""
    if math.isnan(off_range):
        return chain
    # the place is the mean of the echoes before, so the newest is off it by its own error and by that of the mean
    before = max(echoes - 1.0, 1.0)
    d.off_squares[i] += off_range**2 * before / (before + 1.0)
    d.placed[i] += 1.0
    ratio = wander.evidence(d.off_squares[i], d.placed[i], spots.wander_m2, spots.crowd)
    change, d.by_wander[i] = ratio - d.by_wander[i], ratio
    return existence.told_apart(chain, 0.0, change)


@inlined
def _by_onset(d: Doubt, i: int, chain: Chain, of_echo: float, of_spots: float, confirmed: bool) -> Chain:
    """Judge by how sharply the echoes set in: see `onset`. Against a confirmed object it says nothing."""
    if not of_echo > 0.0:
        return chain
    d.sharp[i] += of_echo < onset.SHARP
    d.set_in[i] += 1.0
    ratio = onset.evidence(d.sharp[i], d.set_in[i], of_spots)
    change = ratio - d.by_onset[i]
    if confirmed and change < 0.0:
        return chain
    d.by_onset[i] = ratio
    return existence.told_apart(chain, 0.0, change)


@inlined
def _by_front(d: Doubt, i: int, chain: Chain, of_echo: float, of_spots: float, confirmed: bool) -> Chain:
    """Judge by how the last echoes set in: see `front`. Against a confirmed object it says nothing."""
    if not of_echo > 0.0:
        return chain
    d.fronts[i] = front.FADE * d.fronts[i] + front.log_odds(of_echo)
    d.judged[i] = front.FADE * d.judged[i] + 1.0
    ratio = front.evidence(d.fronts[i], d.judged[i], of_spots)
    change = ratio - d.by_front[i]
    if confirmed and change < 0.0:
        return chain
    d.by_front[i] = ratio
    return existence.told_apart(chain, 0.0, change)


@inlined
def _by_strength(d: Doubt, i: int, chain: Chain, echo_db: float, typical: Typical, k: int) -> Chain:
    """Judge by how strong the echoes are: see `strength`; k: the object's place in `typical`."""
    if not echo_db > 0.0:
        return chain
    d.strength[i] += (echo_db - typical.mean_db[k]) / typical.sigma_db[k]
    d.told[i] += 1.0
    ratio = strength.evidence(d.strength[i] / d.told[i], d.told[i], typical.sigma_db[k], typical.known[k])
    change, d.by_strength[i] = ratio - d.by_strength[i], ratio
    return existence.told_apart(chain, change, change)


@inlined
def _by_motion(d: Doubt, i: int, chain: Chain, ratio: float, spots: float) -> Chain:
    """Judge by motion or size, and by the share of spots at the place, if that is another than before."""
    change = ratio - d.by_motion[i] - (_logit(spots) - _logit(d.spots[i]))
    d.by_motion[i], d.spots[i] = ratio, spots
    return existence.told_apart(chain, 0.0, change)


@inlined
def _logit(share: float) -> float:
    """Return the logarithm of the odds."""
    return math.log(share / (1.0 - share))


@kernel
def intermittent(d: Doubt, i: int, detection_probability: float) -> bool:
    """Tell whether an object is seen as places are where echoes come and go, and not as objects are there."""
    half_way = 0.5 * (detection_probability * d.looks[i] + d.flickers[i])
    return bool(d.flickers[i] > FLICKERING * d.looks[i] and d.hits[i] < half_way)


@kernel
def proof(d: Doubt, i: int) -> float:
    """Return the probability of existence that a new object is confirmed by: see `onset.DEARER`."""
    exists = float(d.visible[i] + d.silent[i])
    if d.set_in[i] == 0.0:
        return exists
    return exists / (exists + onset.DEARER * float(d.nothing[i] + d.spot[i]))


@kernel
def visibilities(table: Floats, returned: float) -> Floats:
    """Return (n,) the probability that an object, if it exists, gives echoes; `returned`: that a silent one does."""
    d, found = doubt_rows(table), np.empty(table.shape[1])
    for i in range(len(found)):
        visible, silent = d.visible[i], d.silent[i]
        found[i] = (visible + silent * returned) / max(visible + silent, existence.SMALLEST)
    return found


@kernel
def as_nothing(table: Floats, ended: Mask) -> tuple[Floats, Counted]:
    """Return what the (n,) `ended` tell as no objects: (2, n) probabilities of a spot, and of none; 0 for the others.

    And what the echoes of spots were like.
    """
    d, chances = doubt_rows(table), np.zeros((2, len(ended)))
    squares, echoes, sharp, set_in, fronts, judged = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    for i in range(len(ended)):
        if ended[i]:
            chances[0, i], chances[1, i] = d.spot[i], d.spot[i] + d.nothing[i]
            squares += d.spot[i] * d.off_squares[i]
            echoes += d.spot[i] * d.placed[i]
            sharp += d.spot[i] * d.sharp[i]
            set_in += d.spot[i] * d.set_in[i]
            fronts += d.spot[i] * d.fronts[i]
            judged += d.spot[i] * d.judged[i]
    return chances, Counted(squares, echoes, sharp, set_in, fronts, judged)
