from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from ods.base.arrays import Floats32
from ods.compiled import native
from ods.messages import Scale
from ods.pipeline.image.samples.amplitude import (
    MAX_AMPLITUDE,
    Decimation,
    mean_offset,
    sample_scale,
    to_amplitude,
)


def linear(frame: NDArray[Any], scale: Scale, factor: float = 1.0, first: int = 0) -> Floats32:
    out = np.empty((frame.shape[0], frame.shape[1] - first), np.float32)
    to_amplitude(frame, Decimation(first, 1, 0, out.shape[1]), sample_scale(frame.dtype, scale, factor), out)
    return out


def test_db_counts_are_decibels_of_amplitude() -> None:
    frame = np.array([[0, 255, 64]], np.uint8)
    np.testing.assert_allclose(linear(frame, "db", 80.0 / 255.0), [[1.0, 1e4, 10.0 ** (64 * 80 / 255 / 20)]], rtol=1e-6)


def test_log8_undoes_the_rule_of_record_7042() -> None:
    amplitude = np.array([[1.0, 12.0, 3456.0, 2.3e6]])
    counts = np.rint(40.0 * np.log10(amplitude)).astype(np.uint8)
    np.testing.assert_allclose(linear(counts, "log8", 40.0), amplitude, rtol=0.03)  # half a count is 2.9 %


@pytest.mark.parametrize("stride", [1, 2, 3, 5])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_averaged_counts_are_means_rounded_down(dtype: type, stride: int) -> None:
    highest = np.iinfo(dtype).max
    frame = np.random.default_rng(0).integers(0, highest, (2, 61), dtype, endpoint=True)
    frame[0, 1:] = highest
    out: NDArray[Any] = np.zeros((2, 14), dtype)
    native.average_counts(frame, Decimation(1, stride, 2, 14), out)
    assert (out[0, 2:] == highest).all()
    assert (out[:, :2] == 0).all()
    exact = frame[:, 1 : 1 + 12 * stride].astype(int).reshape(2, 12, stride).sum(axis=2) // stride
    np.testing.assert_array_equal(out[:, 2:], exact)


def test_offset_makes_the_average_of_counts_that_of_amplitudes() -> None:
    """A count stands for the middle of its step."""
    counts = np.random.default_rng(0).integers(0, 256, (400, 900), np.uint8)
    for stride in (1, 2, 3):
        out = np.zeros((400, 900 // stride), np.uint8)
        native.average_counts(counts, Decimation(0, stride, 0, 900 // stride), out)
        assert out.mean() + mean_offset(stride) == pytest.approx(counts.mean() + 0.5, abs=2e-3)


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
