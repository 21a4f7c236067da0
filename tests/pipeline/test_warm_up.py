"""Everything is compiled before the first ping: none may wait for a compiler."""

import importlib
import pkgutil
from typing import Any

import numpy as np
import pytest

import ods.pipeline
from ods.messages import Pose
from ods.pipeline.chain import Chain
from ods.pipeline.fronts.judge import Fronts
from ods.pipeline.settings import AttentionSettings, PipelineSettings
from ods.pipeline.stage.params import BUILT_IN
from ods.pipeline.stage.registry import find_stage
from ods.pipeline.warm_up import warm_up
from tests.pipeline.pings import body_echo, fan_bearings, make_ping, speckle


def compiled() -> set[tuple[str, str]]:
    """Return (kernel, argument types) of all that is compiled so far."""
    modules = [
        importlib.import_module(part.name) for part in pkgutil.walk_packages(ods.pipeline.__path__, "ods.pipeline.")
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
    warm_up(PipelineSettings())
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


@pytest.mark.parametrize(("dtype", "scale"), [("uint8", "log8"), ("uint16", "linear"), ("float32", "linear")])
def test_nor_does_one_over_a_rough_bed(dtype: str, scale: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where faint echoes are judged by their fronts."""
    warm_up(PipelineSettings())
    before = compiled()
    judged: list[int] = []
    of_echoes = Fronts.judged

    def noted(self: Fronts, echoes: Any, *rest: Any) -> Any:
        judged.append(len(echoes))
        return of_echoes(self, echoes, *rest)

    monkeypatch.setattr(Fronts, "judged", noted)
    rng = np.random.default_rng(4)
    amplitude = 200.0 * speckle(rng, rng.gamma(0.5, 2.0, (60, 2000)))
    counts = 40.0 * np.log10(np.maximum(amplitude, 1.0)) if scale == "log8" else amplitude
    Chain(PipelineSettings()).process(make_ping(counts.astype(dtype), scale=scale, scale_factor=40.0))
    assert judged[0] > 3
    assert compiled() == before


@pytest.mark.parametrize("scale", ["linear", "log8"])
@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float32"])
def test_nor_does_one_of_many_beams(dtype: str, scale: Any) -> None:
    """Sums over 258 beams of 8 bits do not fit 16: the first ping waited for the compiler."""
    warm_up(PipelineSettings())
    before = compiled()
    amplitude = 20.0 * speckle(np.random.default_rng(4), np.ones((512, 2000)))
    factor = 40.0 if scale == "log8" else 1.0
    Chain(PipelineSettings()).process(make_ping(amplitude.astype(dtype), scale=scale, scale_factor=factor))
    assert compiled() == before


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float32"])
def test_nor_does_one_of_what_passes_a_threshold(dtype: str) -> None:
    warm_up(PipelineSettings())
    before = compiled()
    amplitude = 20.0 * speckle(np.random.default_rng(4), np.ones((60, 2000)))
    amplitude[amplitude < 40.0] = 0.0
    Chain(PipelineSettings()).process(make_ping(amplitude.astype(dtype)))
    assert compiled() == before


@pytest.mark.parametrize("dtype", ["uint8", "uint16", "float32"])
@pytest.mark.parametrize("dead", [np.s_[7], np.s_[:30], np.s_[:, 1500:], np.s_[:30, 1000:]], ids=str)
def test_nor_does_one_with_dead_beams(dtype: str, dead: Any) -> None:
    """The process on board compiled for so long that its watchdog killed it, again and again."""
    warm_up(PipelineSettings())
    before = compiled()
    amplitude = 20.0 * speckle(np.random.default_rng(4), np.ones((60, 2000)))
    chain = Chain(PipelineSettings())
    chain.process(make_ping(amplitude.astype(dtype)))
    amplitude[dead] = 0.0
    assert chain.process(make_ping(amplitude.astype(dtype))).unseen_why.startswith("no data")
    assert compiled() == before


@pytest.mark.parametrize("dtype", ["uint8", "uint16"])
@pytest.mark.parametrize("dead", [np.s_[:0], np.s_[7], np.s_[:, 1500:]], ids=str)
def test_nor_does_one_of_few_counts(dtype: str, dead: Any) -> None:
    warm_up(PipelineSettings())
    before = compiled()
    counts = (1.5 * speckle(np.random.default_rng(4), np.ones((60, 2000)))).astype(dtype)
    assert np.mean(counts == 0) > 0.25
    counts[dead] = 0
    Chain(PipelineSettings()).process(make_ping(counts))
    assert compiled() == before


@pytest.mark.parametrize("attention", [AttentionSettings(), AttentionSettings(near_m=30.0, every=2, subsample=2)])
@pytest.mark.parametrize("name", BUILT_IN)
def test_warm_up_covers_every_stage(name: str, attention: AttentionSettings) -> None:
    detector = {"use": name} if find_stage(name).kind == "detect" else {"use": "detect.two_level", "split_db": 6.0}
    before = [{"use": "equalize.mean_range"}] + ([{"use": name}] if find_stage(name).kind != "detect" else [])
    settings = PipelineSettings(stage=(*before, detector), attention=attention)
    chain = Chain(settings, learnt_cells=200_000)
    warm_up(settings)
    known = compiled()
    intensity = np.ones((60, 2000))
    for range_m, bearing in ((15.0, -0.3), (40.0, 0.0), (41.5, 0.06), (80.0, 0.3)):
        intensity += 400.0 * body_echo("half", 1.5, range_m, bearing, fan_bearings(60), 2000)
    rng, zeros = np.random.default_rng(4), (0.0, 0.0, 0.0)
    for number in range(3):
        frame = np.minimum(10.0 * speckle(rng, intensity), 255.0).astype(np.uint8)
        pose = Pose(number, number, number, (0.2 * number, 0.0, 0.0), (1.0, *zeros), zeros, zeros, zeros)
        assert chain.process(make_ping(frame, t_ns=number * 10**8), pose=pose).detections
    assert compiled() == known
