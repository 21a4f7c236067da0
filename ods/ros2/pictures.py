"""Sonar images small enough for a network: the highest of neighbouring samples stands for them."""

import msgspec
import numpy as np

from ods.messages import Ping, frame_of, seen_from_above


def within(ping: Ping, most_bytes: int) -> Ping:
    """Return a ping of at most this number of bytes, with longer samples where it has more; one sample a beam at least.

    A range image is shown from above. Raises ValueError when the samples do not fit their shape.
    """
    ping = seen_from_above(ping)
    samples = frame_of(ping)
    a_sample = ping.beams * samples.itemsize
    if ping.samples * a_sample <= most_bytes:
        return ping
    together = -(-ping.samples // max(1, most_bytes // a_sample))
    whole = ping.samples // together
    pooled = samples[:, : whole * together].reshape(ping.beams, whole, together).max(axis=2)
    return msgspec.structs.replace(
        ping,
        samples=whole,
        data=np.ascontiguousarray(pooled).tobytes(),
        range0_m=ping.range0_m + 0.5 * (together - 1) * ping.dr_m,
        dr_m=ping.dr_m * together,
        no_data=[],
    )
