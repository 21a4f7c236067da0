"""Compilation before the first ping: numba compiles, or loads from its cache, for the sample types that sonars send."""

from itertools import product
from typing import get_args

import numpy as np

from ods.messages import SAMPLE_DTYPES, Ping, SampleType, Scale
from ods.pipeline.chain import Chain

_BEAMS, _SAMPLES = 64, 512


def warm_up(chain: Chain, min_range_m: float) -> None:
    """Process one small made-up ping, with an echo in it, of every sample type, scale and border. Raises StageError.

    Half of the pings begin before `min_range_m`, so that their near end is cut off: other memory layouts, other code.
    """
    for dtype, scale, range0_m in product(get_args(SampleType), get_args(Scale), (min_range_m, min_range_m + 1.0)):
        chain.process(_made_up_ping(dtype, scale, range0_m - 0.5))


def _made_up_ping(dtype: SampleType, scale: Scale, range0_m: float) -> Ping:
    frame = np.random.default_rng(0).rayleigh(10.0, (_BEAMS, _SAMPLES))
    frame[30:34, 200:212] = 200.0
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
        range0_m=range0_m,
        dr_m=0.05,
        sound_speed=1500.0,
        scale=scale,
        scale_factor=40.0 if scale == "log8" else 0.3,
    )
