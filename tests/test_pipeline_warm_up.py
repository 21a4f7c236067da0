"""Everything is compiled before the first ping: none may wait for a compiler."""

import importlib
import pkgutil
from typing import Any

import numpy as np
import pytest
from pipeline_pings import body_echo, fan_bearings, make_ping, speckle

import ods.pipeline
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.warm_up import warm_up


def compiled() -> set[tuple[str, str]]:
    """Return (kernel, argument types) of all that numba has compiled so far."""
    modules = [
        importlib.import_module(f"ods.pipeline.{part.name}") for part in pkgutil.iter_modules(ods.pipeline.__path__)
    ]
    return {
        (name, str(types))
        for module in modules
        for name, item in vars(module).items()
        for types in getattr(item, "signatures", ())
    }


@pytest.mark.parametrize("bodies", [0, 1, 2])
@pytest.mark.parametrize(
    ("dtype", "scale"), [("uint8", "log8"), ("uint8", "db"), ("uint16", "linear"), ("float32", "linear")]
)
def test_no_real_ping_compiles_anything_more(dtype: str, scale: Any, bodies: int) -> None:
    chain = Chain(PipelineSettings())
    warm_up(chain, PipelineSettings().min_range_m)
    before = compiled()
    beams = fan_bearings(60)
    intensity = np.ones((60, 2000))
    for bearing in (-0.3, 0.3)[:bodies]:
        intensity += 400.0 * body_echo("half", 2.0, 40.0, bearing, beams, 2000)
    amplitude = 20.0 * speckle(np.random.default_rng(4), intensity)
    counts = amplitude if scale == "linear" else 40.0 * np.log10(np.maximum(amplitude, 1.0))
    factor = {"log8": 40.0, "db": 0.5, "linear": 1.0}[scale]
    found = chain.process(make_ping(counts.astype(dtype), scale=scale, scale_factor=factor))
    assert len(found.detections) >= bodies
    assert compiled() == before
