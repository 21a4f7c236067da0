"""The false-alarm rate that is set is the one that comes true, whatever the samples mean, the stages do and the sea is.

The images are drawn by benchmarks/clutter.py; counts are compared with closed forms or counted.
`python -m benchmarks.false_alarm` measures many more images and down to 1e-5. Behind a filter, whose crests are some
cells long, the standard error is here 6 % for a rate of 1e-3 and 12 % for 1e-4.
"""

import numpy as np
import pytest
from scipy.special import gamma as gamma_function, gammaincc, kv

from benchmarks.clutter import k_distributed, looks
from benchmarks.false_alarm import CFAR, CHAINS, CLUTTER, FILTERS, KINDS, chain_of, rates

pytestmark = pytest.mark.slow


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("name", ["FIR", "default", "CFAR ca"])
def test_rate_is_kept_on_all_kinds_of_samples(kind: str, name: str) -> None:
    assert 1.0 / 1.5 < rates(kind, [chain_of(*CHAINS[name], 1e-4)], 40).mean() / 1e-4 < 1.5


@pytest.mark.parametrize("name", [name for name in FILTERS if name != "Wiener"])
def test_rate_is_kept_behind_all_filters_but_an_adaptive_one(name: str) -> None:
    assert 1.0 / 1.5 < rates("u1 log8", [chain_of(*CHAINS[name], 1e-3)], 20).mean() / 1e-3 < 1.5


@pytest.mark.parametrize("method", CFAR)
def test_cfar_keeps_its_rate_too(method: str) -> None:
    assert rates("u1 log8", [chain_of(*CHAINS[f"CFAR {method}"], 1e-3)], 20).mean() == pytest.approx(1e-3, rel=0.3)


@pytest.mark.parametrize("clutter", ["4 looks", "K 0.5", "K 2", "K 1, patches"])
def test_rate_is_kept_in_other_clutter(clutter: str) -> None:
    chains = [chain_of(*CHAINS[name], 1e-4) for name in ("FIR", "default")]
    found = rates("u2 linear", chains, 25, CLUTTER[clutter]).mean(axis=1) / 1e-4
    assert (found > 1.0 / 1.5).all()
    assert (found < 1.5).all()


def test_objects_make_false_alarms_rarer() -> None:
    """Ten fill 1 % of the image."""
    found = rates("u2 linear", [chain_of(*CHAINS["FIR"], 1e-3)], 40, objects=10).mean() / 1e-3
    assert 0.2 < found < 1.0


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
