from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from ods.messages import Scale
from ods.pipeline.amplitude import MAX_AMPLITUDE, amplitude_table, to_amplitude


def linear(frame: NDArray[Any], scale: Scale, factor: float = 1.0, first: int = 0) -> NDArray[np.float32]:
    out = np.empty((frame.shape[0], frame.shape[1] - first), np.float32)
    to_amplitude(frame, first, scale, factor, amplitude_table(frame.dtype, scale, factor), out)
    return out


def test_db_counts_are_decibels_of_amplitude() -> None:
    frame = np.array([[0, 255, 64]], np.uint8)
    np.testing.assert_allclose(linear(frame, "db", 80.0 / 255.0), [[1.0, 1e4, 10.0 ** (64 * 80 / 255 / 20)]], rtol=1e-6)


def test_log8_undoes_the_rule_of_record_7042() -> None:
    amplitude = np.array([[1.0, 12.0, 3456.0, 2.3e6]])
    counts = np.rint(40.0 * np.log10(amplitude)).astype(np.uint8)
    np.testing.assert_allclose(linear(counts, "log8", 40.0), amplitude, rtol=0.03)  # half a count is 2.9 %


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_linear_counts_stand_for_the_middle_of_their_step(dtype: type) -> None:
    frame: NDArray[Any] = np.array([[0, 1, 200], [7, 8, 9]], dtype)
    np.testing.assert_array_equal(linear(frame, "linear", first=1), [[1.5, 200.5], [8.5, 9.5]])


def test_sixteen_bit_logarithms_stay_finite() -> None:
    frame = np.array([[0, 100, 65535]], np.uint16)
    result = linear(frame, "db", 0.5)
    assert np.isfinite(result).all()
    assert result[0, 1] == pytest.approx(10.0 ** (50 / 20), rel=1e-6)
    assert result[0, 2] == pytest.approx(MAX_AMPLITUDE, rel=1e-5)


def test_float_samples_of_every_scale() -> None:
    frame = np.array([[-3.0, 0.0, 2.5, 3e38]], np.float32)
    np.testing.assert_allclose(linear(frame, "linear"), [[0.0, 0.0, 2.5, MAX_AMPLITUDE]], rtol=1e-6)
    np.testing.assert_allclose(linear(np.array([[-20.0, 6.0]], np.float32), "db"), [[0.1, 10.0**0.3]], rtol=1e-6)
    np.testing.assert_allclose(linear(np.array([[80.0]], np.float32), "log8", 40.0), [[100.0]], rtol=1e-6)
