"""Preparation of a sonar image for drawing, without matplotlib: its samples in decibels, the borders of its beams."""

import numpy as np

from ods.base.arrays import AnyArray, Floats, Floats32
from ods.messages import Ping, frame_of


def level_db(ping: Ping) -> Floats32:
    """Return the recorded amplitudes of a ping in dB, (beams, samples); 0 dB is an amplitude of one unit.

    Raises ValueError when the ping's buffer does not fit its shape.
    """
    return decibels(frame_of(ping), ping)


def decibels(samples: AnyArray, ping: Ping) -> Floats32:
    """Return samples, of any shape, in dB as those of `ping`."""
    frame = samples.astype(np.float32)
    if ping.scale == "db":
        return frame * np.float32(ping.scale_factor)
    if ping.scale == "log8":
        return frame * np.float32(20.0 / ping.scale_factor)
    half_a_count = 0.0 if ping.dtype == "f4" else 0.5
    return np.asarray(20.0 * np.log10(np.maximum(frame + half_a_count, 1e-6)), np.float32)


def beam_edges(bearing: Floats) -> Floats:
    """Return (beams + 1,) bearings half-way between the beams and as far outside at the ends; a lone beam has 1 deg."""
    if len(bearing) < 2:
        return np.asarray(bearing[0] + np.radians([-0.5, 0.5]))
    middle = 0.5 * (bearing[1:] + bearing[:-1])
    return np.concatenate(([2.0 * bearing[0] - middle[0]], middle, [2.0 * bearing[-1] - middle[-1]]))
