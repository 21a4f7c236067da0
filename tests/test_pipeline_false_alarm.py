"""The false-alarm rate that is set is the one that comes true, whatever the samples mean."""

from typing import Any

import numpy as np
import pytest
from pipeline_pings import make_ping, speckle

from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings

RATE = 1e-4
IMAGES = 60
KINDS: dict[str, dict[str, Any]] = {
    "u1 linear": {},
    "u2 linear": {},
    "u1 log8": {"scale": "log8", "scale_factor": 40.0},
    "u2 db": {"scale": "db", "scale_factor": 0.01},
}


def counts(kind: str, amplitude: np.ndarray) -> np.ndarray:
    if kind == "u1 linear":
        return np.minimum(20.0 * amplitude, 255.0).astype(np.uint8)
    if kind == "u2 linear":
        return np.minimum(900.0 * amplitude, 65535.0).astype(np.uint16)
    if kind == "u1 log8":
        return np.rint(40.0 * np.log10(1.0 + 30.0 * amplitude)).astype(np.uint8)
    return np.rint(2000.0 * np.log10(1.0 + 300.0 * amplitude)).astype(np.uint16)


def realised(kind: str, filters: list[dict[str, Any]], detector: dict[str, Any], images: int = IMAGES) -> float:
    """Share of the cells of pure speckle above the one level."""
    rng = np.random.default_rng(5)
    only = {"use": detector["use"], "rate": RATE, "min_cells": 1} | detector
    chain = Chain(PipelineSettings(stage=({"use": "equalize.mean_range"}, *filters, only), min_range_m=0.0))
    mask = np.zeros((60, 2000), np.int32)
    cells = 0
    for _ in range(images):
        mask[:] = 0
        chain.process(make_ping(counts(kind, speckle(rng, np.ones((60, 2000)))), **KINDS[kind]), mask)
        cells += int((mask > 0).sum())
    return cells / (images * mask.size)


@pytest.mark.parametrize("kind", KINDS)
def test_rate_is_kept_on_all_kinds_of_samples(kind: str) -> None:
    rate = realised(kind, [{"use": "filter.fir"}], {"use": "detect.one_level", "levels": "false_alarm"})
    assert rate == pytest.approx(RATE, rel=0.1)


@pytest.mark.parametrize("filter_name", ["filter.box", "filter.median", "filter.gaussian"])
def test_rate_is_kept_behind_all_filters(filter_name: str) -> None:
    rate = realised("u1 log8", [{"use": filter_name}], {"use": "detect.one_level", "levels": "false_alarm"})
    assert rate == pytest.approx(RATE, rel=0.2)


@pytest.mark.parametrize("method", ["ca", "goca", "soca", "os"])
def test_cfar_keeps_its_rate_too(method: str) -> None:
    detector = {"use": "detect.cfar", "method": method, "low": 50.0}
    rate = realised("u1 log8", [{"use": "filter.fir"}], detector, 15)
    assert rate == pytest.approx(RATE, rel=0.5)
