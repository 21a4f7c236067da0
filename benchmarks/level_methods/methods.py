"""The methods: each turns a ping into detections, at a level that is swept. They share equalizers and filter."""

from collections import deque
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from msgspec.structs import replace

from benchmarks.level_methods.cases import PINGS, Look
from benchmarks.level_methods.features import BASE, Weights, log_odds
from benchmarks.level_methods.laws import LAWS
from ods.assess.detection.measure import SWEEP_CELLS
from ods.base.arrays import Floats, Image
from ods.base.geometry import body_to_global, polar_to_body
from ods.messages import Detection
from ods.pipeline.chain import Chain
from ods.pipeline.detect.grouping import DetectionLevels, Grouping
from ods.pipeline.detect.noise import NoiseMeter
from ods.pipeline.image.fan import Fan
from ods.pipeline.image.recorded import Recorded
from ods.pipeline.image.regions import Regions
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.params import TwoLevelParams
from ods.pipeline.stage.registry import detect_stage
from ods.pipeline.stage.step import PreparedDetector

Find = Callable[[Look], list[Detection]]
LOW = 2.5
WANTED = 3
"""Pings, of PINGS, that have to show an echo at a place."""
NEAR_M = 1.0
"""Echoes this near, and a beam's spacing, are of one place."""
LEVELS = (30.0, 18.0, 12.0, 9.0, 7.0, 6.0, 5.0, 4.3, 3.6, 3.0)
_DEFAULT = PipelineSettings().at_spacing(0.05)


class LawParams(TwoLevelParams, frozen=True):
    """benchmark.law: `detect.two_level` with another law by region."""

    law: str = "k"


@detect_stage("benchmark.law", LawParams)
def by_law(params: LawParams, fan: Fan) -> PreparedDetector:
    """Find regions as `detect.two_level` does, on the image that the law has levelled."""
    meter, group, law = NoiseMeter(), Grouping(params, fan), LAWS[params.law](fan.shape)

    def find(image: Image, recorded: Recorded) -> Regions:
        background, noise = meter.background_and_noise(image)
        if background <= 0.0 or noise <= 0.0:
            return group.nothing(image)
        judged = law.levelled(image, (background, noise), params.high)
        levels = DetectionLevels(background + params.low * noise, background + params.high * noise, background)
        return group.regions(judged, recorded, levels)

    def learn(kinds: Iterable[Iterable[Image]]) -> None:
        law.learn(next(iter(kinds)))  # speckle of one look

    return PreparedDetector(find, learn, refuses_nan=True)


@dataclass(frozen=True)
class Method:
    """One way to make levels follow the background."""

    name: str
    at: Callable[[float], Find]
    """Returns the method at a level, higher ones for fewer echoes."""
    levels: tuple[float, ...] = LEVELS
    """From few false echoes to many."""
    pings: int = 1
    """That it needs."""
    plain: bool = False
    """Of numpy, not of kernels: its time is no measure of the method."""


def methods(weights: Weights) -> list[Method]:
    """Return all methods; weights: of the region features."""
    rates = tuple(np.linspace(9.0, 2.5, 12).tolist())
    cfar = [Method(f"CFAR {name}", partial(_cfar, name), rates) for name in ("ca", "goca", "os")]
    laws = {"k": "K fit", "gamma": "generalised gamma", "pareto": "generalised Pareto", "ring": "ring contrast"}
    return [
        Method("one level", partial(_two_level, 0.0)),
        Method("extreme values 0.3", partial(_two_level, 0.3)),
        Method("extreme values 1", partial(_two_level, 1.0)),
        Method("tail of the image", _tail, rates),
        *(Method(name, partial(_law, law), plain=True) for law, name in laws.items()),
        *cfar,
        Method("region features", partial(_features, weights), tuple(np.linspace(8.0, -8.0, 12).tolist()), plain=True),
        Method(f"{WANTED} of {PINGS} pings", _persistence, (12.0, 9.0, 7.0, 5.5, 4.5, 3.8, 3.2, 2.8, 2.4, 2.0), PINGS,
               plain=True),
    ]  # fmt: skip


def _chain(detector: dict[str, Any]) -> Chain:
    *before, usual = _DEFAULT.stage
    shared = {key: value for key, value in usual.items() if key in ("min_cells", "strongest", "border")}
    return Chain(replace(_DEFAULT, stage=(*before, shared | detector)), learnt_cells=SWEEP_CELLS)


def _plainly(detector: dict[str, Any]) -> Find:
    chain = _chain(detector)
    return lambda look: chain.process(look.ping).detections


def _two_level(follow: float, level: float) -> Find:
    levels = {"high": level, "low": min(LOW, level), "follow": follow, "faint": follow}
    return _plainly({"use": "detect.two_level", **levels})


def _tail(level: float) -> Find:
    return _plainly({"use": "detect.two_level", "levels": "false_alarm", "rate": 10.0**-level})


def _law(law: str, level: float) -> Find:
    return _plainly({"use": "benchmark.law", "law": law, "high": level, "low": min(LOW, level)})


def _cfar(method: str, level: float) -> Find:
    return _plainly({"use": "detect.cfar", "method": method, "rate": 10.0**-level})


def _features(weights: Weights, level: float) -> Find:
    base = _two_level(0.0, BASE)

    def find(look: Look) -> list[Detection]:
        found = base(look)
        odds = log_odds(weights, look.ping, found)
        return [one for one, value in zip(found, odds, strict=True) if value >= level]

    return find


def _persistence(level: float) -> Find:
    base = _two_level(0.0, level)
    former: deque[Floats] = deque(maxlen=PINGS - 1)

    def find(look: Look) -> list[Detection]:
        found = base(look)
        table = np.array([(one.range_m, one.bearing_rad, one.elevation_rad) for one in found]).reshape(-1, 3)
        places = body_to_global(polar_to_body(*table.T), look.place, look.attitude)
        gate = NEAR_M + table[:, 0] * (look.ping.bearing_rad[1] - look.ping.bearing_rad[0])
        seen = np.ones(len(found), np.int64)
        for others in former:
            away = np.hypot(*(places[:, None, :2] - others[:, :2]).transpose(2, 0, 1))
            seen += (away <= gate[:, None]).any(axis=1)
        former.append(places)
        return [one for one, times in zip(found, seen, strict=True) if times >= WANTED]

    return find
