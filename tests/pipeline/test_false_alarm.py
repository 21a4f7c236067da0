"""The false-alarm rate that is set is the one that comes true, whatever the samples mean, the stages do and the sea is.

The images are drawn by benchmarks/detection/clutter.py, which has nothing in common with what detectors learn from;
counts are compared with closed forms or counted. `python -m benchmarks.detection.false_alarm` measures many more images
and down to 1e-5. Behind a filter, whose crests are some cells long, the standard error is here about 2 % for a rate of
1e-3 and 6 % for 1e-4; the rest of the tolerance is for what is learnt.
"""

import numpy as np
import pytest
from scipy.special import gamma as gamma_function, gammaincc, kv

from benchmarks.detection.clutter import k_distributed, looks
from benchmarks.detection.false_alarm import CFAR, CHAINS, CLUTTER, FILTERS, KINDS, chain_of, rates
from ods.pipeline.prepared.speckle import KINDS as LEARNT, Speckle, speckle_generator

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("kind", KINDS)
def test_rate_is_kept_on_all_kinds_of_samples(kind: str) -> None:
    assert rates(kind, [chain_of(*CHAINS["FIR"], 1e-4)], 40).mean() == pytest.approx(1e-4, rel=0.25)


@pytest.mark.parametrize("name", FILTERS)
def test_rate_is_kept_behind_all_filters(name: str) -> None:
    assert rates("u1 log8", [chain_of(*CHAINS[name], 1e-3)], 20).mean() == pytest.approx(1e-3, rel=0.25)


@pytest.mark.parametrize("method", CFAR)
def test_cfar_keeps_its_rate_too(method: str) -> None:
    assert rates("u1 log8", [chain_of(*CHAINS[f"CFAR {method}"], 1e-3)], 20).mean() == pytest.approx(1e-3, rel=0.2)


@pytest.mark.parametrize("clutter", ["4 looks", "K 0.5", "K 2", "K 1, patches", "field correlated, 2"])
def test_rate_is_kept_in_other_clutter(clutter: str) -> None:
    """With one look only learnt, 4 looks came to 1.8 and 3.8 times, K 2 to 1.6 and 2.1 times the one set."""
    chains = [chain_of(*CHAINS[name], 1e-4) for name in ("none", "FIR")]
    found = rates("u2 linear", chains, 25, CLUTTER[clutter]).mean(axis=1) / 1e-4
    assert (found > 1.0 / 1.5).all()
    assert (found < 1.5).all()


def test_counts_of_few_bits_do_not_spoil_the_level() -> None:
    """Between two counts of so narrow a tail lies a factor of 1.9; the rate was 2.5 to 2.9 times the one set."""
    found = rates("u1 linear", [chain_of(*CHAINS["as recorded"], 1e-4)], 25, CLUTTER["4 looks"]).mean() / 1e-4
    assert 1.0 / 1.5 < found < 1.5


def test_ten_objects_do_not_raise_the_level() -> None:
    """They fill 1 % of the image; the rate was a twentieth of the one set."""
    found = rates("u2 linear", [chain_of(*CHAINS["FIR"], 1e-4)], 40, objects=10).mean() / 1e-4
    assert 1.0 / 1.5 < found < 1.5


@pytest.mark.parametrize("level", [1.0, 2.0, 3.0])
def test_benchmarks_clutter_follows_its_closed_form(level: float) -> None:
    """Share of amplitudes above a level: gamma, and K (E. Jakeman, P. N. Pusey, IEEE Trans. AP 24, 1976)."""
    rng = np.random.default_rng(3)
    of_looks = gammaincc(4.0, 4.0 * level**2)
    at = 2.0 * level * np.sqrt(2.0)
    of_k = 2.0 / gamma_function(2.0) * (at / 2.0) ** 2.0 * kv(2.0, at)
    for clutter, share in ((looks(4), of_looks), (k_distributed(2.0), of_k), (k_distributed(2.0, (1.0, 8.0)), of_k)):
        counted = np.mean([np.mean(clutter(rng, (60, 2000)) > level) for _ in range(10)])
        assert counted == pytest.approx(share, rel=0.05, abs=2e-5)


@pytest.mark.parametrize("kind", LEARNT)
def test_learnt_speckle_has_the_moments_of_its_kind(kind: Speckle) -> None:
    """Mean intensity 1; mean square (1 + 1 / looks)(1 + 1 / shape), times that of the trend."""
    out = np.empty((200, 2000), np.float32)
    speckle_generator(kind, np.random.Generator(np.random.SFC64(1)))(out)
    intensity = out.astype(np.float64)
    expected = (1.0 + 1.0 / kind.looks) * (1.0 + (1.0 / kind.texture if kind.texture else 0.0))
    trend = kind.louder ** np.linspace(0.0, 2.0, 2000)
    expected *= float(np.mean(trend**2) / np.mean(trend) ** 2)
    assert intensity.mean() == pytest.approx(1.0, rel=0.05)
    assert (intensity**2).mean() == pytest.approx(expected, rel=0.2)
