"""Packets of the Norbit WBMS as the sonar itself writes them, by packed record types.

Written from the maker's TN-180196, not from `ods.sonar_link.norbit`: the bench would show a mistake there.
"""

import zlib
from typing import NamedTuple

import numpy as np

from ods.base.arrays import AnyArray, Floats, Image

WATER_COLUMN, VERSION = 2, 4
UINT16 = 2
EQUAL_ANGLES_512 = 1

_HEADER = np.dtype([
    ("preamble", "<u4"), ("type", "<u4"), ("size", "<u4"), ("version", "<u4"), ("reserved", "<u4"), ("crc", "<u4"),
])  # fmt: skip
_WATER_COLUMN = np.dtype([
    ("header", _HEADER), ("snd_velocity", "<f4"), ("sample_rate", "<f4"), ("n", "<u4"), ("m", "<u4"), ("time", "<f8"),
    ("dtype", "<u4"), ("t0", "<i4"), ("gain", "<f4"), ("reserved_1", "<u4"), ("swath_dir", "<f4"),
    ("swath_open", "<f4"), ("tx_freq", "<f4"), ("tx_bw", "<f4"), ("tx_len", "<f4"), ("tx_amp", "<u4"),
    ("reserved_2", "<u2", 2), ("reserved_3", "<f4", 2), ("ping_rate", "<f4"), ("reserved_4", "<f4"),
    ("ping_number", "<u4"), ("time_net", "<f8"), ("beams", "<u4"), ("vga_t1", "<i4"), ("vga_g1", "<f4"),
    ("vga_t2", "<i4"), ("vga_g2", "<f4"), ("reserved_5", "<u2", 2), ("tx_angle", "<f4"), ("tx_voltage", "<f4"),
    ("beam_dist_mode", "u1"), ("sonar_mode", "u1"), ("reserved_6", "<u2"), ("gate_tilt", "<f4"),
    ("reserved_7", "<f4"), ("reserved_8", "u1", 28),
])  # fmt: skip


class ImageSays(NamedTuple):
    """Description of the image in a packet."""

    sound_speed: float
    sample_rate_hz: float
    time_s: float
    first_sample: int
    bearing_rad: Floats
    opening_rad: float
    frequency_khz: float
    bandwidth_khz: float
    pulse_s: float
    amplitude: int
    ping_rate_hz: float
    number: int
    gain_db: tuple[float, float]
    """At the first sample and at the last."""
    mode: int


def water_column(says: ImageSays, amplitude: Image, full_scale: float) -> bytes:
    """Return the packet of an image, (beams, samples) amplitude; `full_scale`: that of the highest sample value."""
    lines = np.ascontiguousarray(to_samples(amplitude, full_scale).T)
    samples, beams = lines.shape
    record = np.zeros(1, _WATER_COLUMN)[0]
    record["snd_velocity"], record["sample_rate"] = says.sound_speed, says.sample_rate_hz
    record["n"], record["m"], record["dtype"] = beams, samples, UINT16
    record["time"] = record["time_net"] = says.time_s
    record["t0"], record["gain"] = says.first_sample, 1.0
    record["swath_open"] = says.opening_rad
    record["tx_freq"], record["tx_bw"] = says.frequency_khz, says.bandwidth_khz
    record["tx_len"], record["tx_amp"] = says.pulse_s, says.amplitude
    record["ping_rate"], record["ping_number"] = says.ping_rate_hz, says.number % 2**32
    record["beams"], record["beam_dist_mode"], record["sonar_mode"] = beams, EQUAL_ANGLES_512, says.mode
    record["vga_t1"], record["vga_t2"] = says.first_sample, says.first_sample + samples
    record["vga_g1"], record["vga_g2"] = says.gain_db
    record["tx_voltage"] = np.nan
    body: bytes = record.tobytes()[_HEADER.itemsize :] + lines.tobytes() + says.bearing_rad.astype("<f4").tobytes()
    head = record["header"]
    head["preamble"], head["type"], head["version"] = 0xDEADBEEF, WATER_COLUMN, VERSION
    head["size"], head["crc"] = _HEADER.itemsize + len(body), zlib.crc32(body)
    return bytes(head.tobytes()) + body


def to_samples(amplitude: Image, full_scale: float) -> AnyArray:
    """Return 16-bit samples: the share of the full scale, rounded."""
    share = np.minimum(amplitude * np.float32(1.0 / full_scale), np.float32(1.0))
    return np.asarray(np.rint(share * np.float32(2**16 - 1)).astype("<u2"))
