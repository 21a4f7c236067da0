"""What speaks for and against the existence of each live object, and what an image adds to that."""

from typing import NamedTuple

import numpy as np

from ods.base.arrays import Floats, Ints, Mask
from ods.compiled import native
from ods.tracker.association import front, onset, strength
from ods.tracker.settings import EchoSettings
from ods.tracker.track import existence
from ods.tracker.track.existence import Rates

LAWS = onset.LAW, front.LAW, strength.LAW, existence.SEEN
"""By which bodies, spots and nothing are told apart, for C: `Laws`."""


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
    """and images in which there might have been one."""
    strength: Floats
    """Sum over its echoes of what they have over the echoes of nothing, in standard deviations of these,"""
    told: Floats
    """and number of the echoes that tell their strength;"""
    by_strength: Floats
    """the log-likelihood ratio taken of that;"""
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
    """the share of spots that it is judged by."""


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
    onset: Floats
    """How slowly it sets in, see `onset`; 0: none, or one that is not all of the object and only of it, or not told."""
    front: Floats
    """How likely such an echo's front is a body's; 0: none, or not told."""


class AtPlaces(NamedTuple):
    """What echoes of nothing are like at n places."""

    spots: float
    """Share of spots, which come and go, among them: see `flicker`."""
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

    sharp: float
    """Share of them that set in sharply."""
    front: float
    """Mean of their fronts' log-odds."""
    crowd: float
    """How much of a crowd they are, from 0 to 1: see `crowd`."""


class Counted(NamedTuple):
    """Of the echoes of tracks that ended as spots."""

    sharp: float
    """How many set in sharply"""
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
    spots: Spots


def assumed(echo: EchoSettings, spots: Spots) -> Assumed:
    """Return what the settings say, and what was learned of spots."""
    rates = Rates(echo.silence_rate, echo.return_rate, echo.loss_rate)
    return Assumed(rates, echo.detection_probability, spots)


def begin(table: Floats, first: int, births: float, unknown: Unexplained) -> None:
    """Set objects from `first` on in a table of `Doubt`, one an unexplained echo, given births a scan."""
    native.doubt_begin(table, first, births, unknown, LAWS)


def take_image(
    table: Floats,
    seen: tuple[Ints, Mask, Mask],
    look: Floats,
    nothing: AtPlaces,
    dt: float,
    known: Assumed,
) -> None:
    """Judge by an image, `dt` seconds after the one before; tables of `Doubt` and `Look`.

    `seen`: (n,) echoes so far, this one too, which objects are confirmed, and which had an echo.
    """
    native.doubt_take_image(table, seen, look, nothing, dt, known, LAWS)


def proof(table: Floats, i: int) -> float:
    """Return the probability of existence that new object i is confirmed by: see `onset.DEARER`."""
    probability: float = native.doubt_proof(table, i, onset.DEARER)
    return probability


def visibilities(table: Floats, returned: float) -> Floats:
    """Return (n,) the probability that an object, if it exists, gives echoes; `returned`: that a silent one does."""
    found = np.empty(table.shape[1])
    native.doubt_visibilities(table, returned, found)
    return found


def as_nothing(table: Floats, ended: Mask) -> tuple[Floats, Counted]:
    """Return what the (n,) `ended` tell as no objects: (2, n) probabilities of a spot, and of none; 0 for the others.

    And what the echoes of spots were like.
    """
    chances, counted = np.empty((2, len(ended))), np.empty(len(Counted._fields))
    native.doubt_as_nothing(table, ended, chances, counted)
    return chances, Counted(*counted.tolist())
