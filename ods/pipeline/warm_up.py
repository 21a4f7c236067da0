"""Compilation before the first ping: numba compiles, or loads from its cache, for the sample types that sonars send."""

from itertools import product
from typing import get_args

import msgspec
import numpy as np

from ods.messages import SAMPLE_DTYPES, Ping, Pose, SampleType, Scale, frame_of
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.watch import Watch

_BEAMS, _SAMPLES = 64, 512
_MANY_BEAMS = 258
"""8-bit samples of more beams than 257 are summed by other code."""
_PINGS = 3
"""So many, at least, to stages that compare pings."""
_LEARNT_CELLS = 200_000
FEW_COUNTS, MOSTLY_ZEROS = 10, 100
"""So many times as quiet."""


def warm_up(settings: PipelineSettings, watch: Watch | None = None) -> None:
    """Let the chain of these settings process small made-up pings of every sample type, scale and border.

    watch: see `Chain`; images that are shown are made by other code. Raises StageError.
    Half of the pings begin before the least range, so that their near end is cut off: other memory layouts, other code.
    Half have a beam that is louder than the others, whose gain then is not 1; half have beams without data. Quiet
    images become whole ones before anything else, so that those of one geometry will do: a slow stage of a user's sees
    all of this. Of each geometry there are enough for all phases of attention and for stages that compare pings.
    """
    dr_m = max(0.05, 2.0 * settings.attention.near_m / _SAMPLES)  # so that there are rings beyond
    phases = settings.attention.every if settings.attention.near_m > 0.0 else 1
    zeros = (0.0, 0.0, 0.0)
    kinds = list(product(get_args(SampleType), get_args(Scale)))
    geometries = product((1, 3), (settings.min_range_m - 0.5, settings.min_range_m + 0.5))
    for geometry, (gain, range0_m) in enumerate(geometries):
        chain = Chain(settings, learnt_cells=_LEARNT_CELLS, watch=watch)
        for number, (dtype, scale) in enumerate(kinds):
            count = phases if number else max(phases, _PINGS)
            for phase in range((2 if geometry else 4) * count):
                pose = Pose(phase, phase, phase, (0.1 * phase, 0.0, 0.0), (1.0, *zeros), zeros, zeros, zeros)
                ping = made_up_ping(dtype, scale, range0_m, dr_m, gain)
                shown = (ping, lossy(ping), lossy(ping, FEW_COUNTS), lossy(ping, MOSTLY_ZEROS))
                chain.process(shown[phase // count], pose=pose)
    chain = Chain(settings, learnt_cells=_LEARNT_CELLS, watch=watch)
    for scale in get_args(Scale):
        chain.process(made_up_ping("u1", scale, settings.min_range_m, dr_m, beams=_MANY_BEAMS))


def lossy(ping: Ping, quiet: int = 1) -> Ping:
    """Return the ping with a beam that is dead and one that is cut short, which it tells; so many times as quiet, too.

    Counts of 0 to 4 are dithered; mostly zeros are taken for what did not pass a threshold. Each is other code.
    """
    frame = frame_of(ping) // quiet
    frame[7], frame[9, _SAMPLES // 2 :] = 0, 0
    no_data = [(7, 0, _SAMPLES), (9, _SAMPLES // 2, _SAMPLES)]
    return msgspec.structs.replace(ping, data=frame.tobytes(), no_data=no_data)


def made_up_ping(
    dtype: SampleType, scale: Scale, range0_m: float, dr_m: float, gain: int = 1, beams: int = _BEAMS
) -> Ping:
    """Return a small ping of speckle and some echoes, one beam of which is `gain` times as loud."""
    frame = np.resize(np.random.default_rng(0).rayleigh(10.0, (_BEAMS, _SAMPLES)), (beams, _SAMPLES))
    frame[20] *= gain
    frame[30:34, 100::100] = 200.0
    return Ping(
        seq=0,
        ping_number=0,
        t_ns=0,
        t_rx_ns=0,
        utc_ns=0,
        beams=beams,
        samples=_SAMPLES,
        dtype=dtype,
        data=np.minimum(frame, 255.0).astype(SAMPLE_DTYPES[dtype]).tobytes(),
        bearing_rad=np.linspace(-0.2, 0.2, beams).tolist(),
        range0_m=range0_m,
        dr_m=dr_m,
        sound_speed=1500.0,
        scale=scale,
        scale_factor=40.0 if scale == "log8" else 0.3,
    )
