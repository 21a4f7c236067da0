"""A loud spell: noise of others in the image."""

import numpy as np
import pytest

from ods.sim_sonar.receiver.blindness import BLINDNESS


def loud(image: np.ndarray[tuple[int, ...], np.dtype[np.float32]]) -> np.ndarray[tuple[int, ...], np.dtype[np.float32]]:
    spoilt = image.copy()
    BLINDNESS["loud"](spoilt)
    return spoilt


def test_noise_is_20_db_over_the_median_level_and_another_one_in_each_ping() -> None:
    quiet = np.full((60, 500), 3.0, np.float32)
    added = loud(quiet) - quiet
    assert np.sqrt(np.mean(added.astype(np.float64) ** 2)) == pytest.approx(
        10.0 * 3.0 * np.sqrt(2.0), rel=0.02
    )  # Rayleigh
    assert (loud(quiet) == loud(quiet)).all()
    quiet[0, 0] = 4.0
    assert np.corrcoef((loud(quiet) - quiet).ravel(), added.ravel())[0, 1] == pytest.approx(0.0, abs=0.03)
