"""Amplitudes to the samples that a sonar sends: 8-bit logarithmic, 8 and 16 bits linear; and pings of them."""

import numpy as np

from ods.base.arrays import AnyArray, Bytes, Image
from ods.compiled import native
from ods.messages import Ping
from ods.sim_sonar.receiver.settings import ImageLevels
from ods.sim_sonar.sonar.model import SonarModel

MANTISSA = 10
"""Bits of the mantissa that the logarithm's table knows."""
SHIFT = 23 - MANTISSA
WHOLE_SAMPLE = 1e-3
"""Share of a sample that the first range may lie off a whole number of samples."""


def quantize_linear(amplitude: Image, full_scale: float, dtype: type[np.uint8] | type[np.uint16]) -> AnyArray:
    """Return amplitude / full_scale in shares of the type's highest value, rounded, at most that value."""
    highest = np.float32(np.iinfo(dtype).max)
    levels = amplitude * (highest / np.float32(full_scale))
    np.minimum(np.rint(levels, out=levels), highest, out=levels)
    return np.asarray(levels.astype(dtype))


class LogQuantizer:
    """a = factor * log10(amplitude), rounded, 0 under 1 count, at most 255: record 7042's rule.

    By thresholds: exact, and ten times faster than logarithms.
    """

    def __init__(self, factor: float = 40.0) -> None:
        levels = (np.arange(1, 256) - 0.5) / factor
        capped = np.where(levels < 38.0, 10.0 ** np.minimum(levels, 38.0), np.inf)
        self._thresholds = np.concatenate([np.maximum(capped, 1.0), [np.inf]]).astype(np.float32)
        count = int(np.float32(np.inf).view(np.uint32)) >> SHIFT
        floors = (np.arange(count + 1, dtype=np.uint32) << np.uint32(SHIFT)).view(np.float32)
        self._table = np.searchsorted(self._thresholds, floors, side="right").clip(0, 255).astype(np.uint8)

    def __call__(self, amplitude: Image) -> Bytes:
        """Return the uint8 samples of amplitudes, float32 of any shape, 0 or more."""
        samples = np.empty(amplitude.size, np.uint8)
        flat = np.ascontiguousarray(amplitude, np.float32).reshape(-1)
        native.look_up_levels(flat, self._table, self._thresholds, SHIFT, samples)
        return samples.reshape(amplitude.shape)


class PingMaker:
    """Makes pings of a sonar's images; linear 16-bit ones start at range 0, as record 7018 has no first range."""

    def __init__(self, sonar: SonarModel, levels: ImageLevels) -> None:
        self._sonar, self._levels = sonar, levels
        self._log = LogQuantizer(levels.log_factor)
        self._lead = round(sonar.range0_m / sonar.dr_m) if levels.samples == "linear16" else 0
        if self._lead and abs(sonar.range0_m / sonar.dr_m - self._lead) > WHOLE_SAMPLE:
            self._lead = 0
        self._geometry = {
            "beams": sonar.beams,
            "samples": sonar.samples + self._lead,
            "bearing_rad": sonar.bearing_rad.tolist(),
            "range0_m": 0.0 if self._lead else sonar.range0_m,
            "dr_m": sonar.dr_m,
            "sound_speed": sonar.sound_speed,
            "elevation_rad": sonar.elevation_rad.tolist(),
            "beam_width_rad": [sonar.beam_width_rad] * sonar.beams,
            "planes": sonar.planes,
            "frequency_hz": sonar.frequency_hz,
        }

    def __call__(self, image: Image, ping_number: int, t_ns: int, utc_ns: int) -> Ping:
        """Return `image`, amplitude in counts, (beams, samples) float32, as a ping; t_ns is its transmit time."""
        kind = self._levels.samples
        if kind == "log8":
            frame: AnyArray = self._log(image)
        else:
            dtype = np.uint8 if kind == "linear8" else np.uint16
            frame = quantize_linear(image, self._levels.full_scale_counts, dtype)
            frame = np.pad(frame, ((0, 0), (self._lead, 0)))
        return Ping(
            seq=ping_number,
            ping_number=ping_number,
            t_ns=t_ns,
            t_rx_ns=t_ns,
            utc_ns=utc_ns,
            dtype="u2" if kind == "linear16" else "u1",
            data=frame.tobytes(),
            scale="log8" if kind == "log8" else "linear",
            scale_factor=self._levels.log_factor if kind == "log8" else 1.0,
            **self._geometry,
        )
