"""Compilation before the first ping: numba compiles, or loads from its cache, for the sample types that sonars send."""

from typing import get_args

import numpy as np

from ods.messages import SAMPLE_DTYPES, Ping, SampleType
from ods.pipeline.chain import Chain

_BEAMS, _SAMPLES = 16, 256


def warm_up(chain: Chain) -> None:
    """Process one small made-up ping, with an echo in it, of every sample type. Raises StageError."""
    for dtype in get_args(SampleType):
        chain.process(_made_up_ping(dtype))


def _made_up_ping(dtype: SampleType) -> Ping:
    frame = np.random.default_rng(0).rayleigh(10.0, (_BEAMS, _SAMPLES))
    frame[6:10, 100:130] += 150.0
    return Ping(
        seq=0,
        ping_number=0,
        t_ns=0,
        t_rx_ns=0,
        utc_ns=0,
        beams=_BEAMS,
        samples=_SAMPLES,
        dtype=dtype,
        data=np.minimum(frame, 255.0).astype(SAMPLE_DTYPES[dtype]).tobytes(),
        bearing_rad=np.linspace(-0.2, 0.2, _BEAMS).tolist(),
        range0_m=1000.0,  # beyond any configured minimum range
        dr_m=0.05,
        sound_speed=1500.0,
    )
