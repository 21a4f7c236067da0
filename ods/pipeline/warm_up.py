"""Before the first ping: a stage that fails does so at the start, and the first ping is as quick as the others."""

from typing import get_args

import numpy as np

from ods.base.arrays import SAMPLE_DTYPES
from ods.messages import Ping, Pose, SampleType, Scale
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings

_BEAMS, _SAMPLES = 64, 512
_PINGS = 3
"""Least number of pings for stages that compare them."""
_LEARNT_CELLS = 200_000


def warm_up(settings: PipelineSettings) -> None:
    """Let the chain of these settings process small made-up pings of every sample type. Raises StageError.

    There are enough of them for all phases of attention and for stages that compare pings.
    """
    dr_m = max(0.05, 2.0 * settings.attention.near_m / _SAMPLES)  # so that there are rings beyond
    phases = settings.attention.every if settings.attention.near_m > 0.0 else 1
    zeros = (0.0, 0.0, 0.0)
    chain = Chain(settings, learnt_cells=_LEARNT_CELLS)
    for dtype in get_args(SampleType):
        ping = made_up_ping(dtype, "linear", settings.min_range_m + 0.5, dr_m)
        for phase in range(max(phases, _PINGS)):
            pose = Pose(phase, phase, phase, (0.1 * phase, 0.0, 0.0), (1.0, *zeros), zeros, zeros, zeros)
            chain.process(ping, pose=pose)


def made_up_ping(dtype: SampleType, scale: Scale, range0_m: float, dr_m: float) -> Ping:
    """Return a small ping of speckle and some echoes."""
    frame = np.random.default_rng(0).rayleigh(10.0, (_BEAMS, _SAMPLES))
    frame[30:34, 100::100] = 200.0
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
        dr_m=dr_m,
        sound_speed=1500.0,
        scale=scale,
        scale_factor=40.0 if scale == "log8" else 0.3,
    )
