"""A second reader of .s7k files, for tests: the tables of the 7k Data Format Definition 3.12, and nothing of ods.

Layouts: sections 5, 10.5, 10.14, 10.15, 10.22, 10.23, 10.27, 10.36, 10.47, 10.59, 10.60; texts of 3001 as in MB-System.
"""

import struct
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Any

import numpy as np

Table = list[tuple[str, str]]

FRAME: Table = [
    ("version", "H"), ("offset", "H"), ("sync", "I"), ("size", "I"), ("optional_at", "I"), ("optional_id", "I"),
    ("time", "10s"), ("record_version", "H"), ("type", "I"), ("device", "I"), ("", "H"), ("enumerator", "H"),
    ("", "I"), ("flags", "H"), ("", "H"), ("", "I"), ("records", "I"), ("fragment", "I"),
]  # fmt: skip
HEADS: dict[int, Table] = {
    1003: [
        ("datum", "I"), ("latency", "f"), ("latitude", "d"), ("longitude", "d"), ("height", "d"), ("kind", "B"),
        ("utm_zone", "B"), ("quality", "B"), ("method", "B"), ("satellites", "B"),
    ],
    1012: [("roll", "f"), ("pitch", "f"), ("heave", "f")],
    1013: [("heading", "f")],
    3001: [
        ("target", "I"), ("ping_number", "I"), ("time", "10s"), ("operator", "128s"), ("state", "I"), ("range", "f"),
        ("bearing", "f"), ("flags", "I"), ("latitude", "d"), ("longitude", "d"), ("azimuth", "f"), ("length", "f"),
        ("width", "f"), ("classification", "128s"), ("description", "128s"),
    ],
    7000: [
        ("sonar", "Q"), ("ping_number", "I"), ("multi_ping", "H"), ("frequency", "f"), ("sample_rate", "f"),
        ("bandwidth", "f"), ("pulse_width", "f"), ("pulse_type", "I"), ("envelope", "I"), ("envelope_parameter", "f"),
        ("pulse_mode", "H"), ("", "H"), ("max_rate", "f"), ("period", "f"), ("range", "f"), ("power", "f"),
        ("gain", "f"), ("control", "I"), ("projector", "I"), ("steering_v", "f"), ("steering_h", "f"),
        ("width_v", "f"), ("width_h", "f"), ("focus", "f"), ("window", "I"), ("window_parameter", "f"),
        ("transmit_flags", "I"), ("hydrophone", "I"), ("rx_window", "I"), ("rx_parameter", "f"), ("rx_flags", "I"),
        ("rx_width", "f"), ("min_range", "f"), ("max_range", "f"), ("min_depth", "f"), ("max_depth", "f"),
        ("absorption", "f"), ("sound_velocity", "f"), ("spreading", "f"), ("", "H"),
    ],
    7004: [("sonar", "Q"), ("beams", "I")],
    7018: [("sonar", "Q"), ("ping_number", "I"), ("multi_ping", "H"), ("beams", "H"), ("samples", "I"), ("", "32s")],
    7042: [
        ("sonar", "Q"), ("ping_number", "I"), ("multi_ping", "H"), ("beams", "H"), ("samples", "I"),
        ("compressed_samples", "I"), ("flags", "I"), ("first_sample", "I"), ("sample_rate", "f"), ("factor", "f"),
        ("", "I"),
    ],
    7200: [
        ("file_identifier", "16s"), ("version", "H"), ("", "H"), ("session", "16s"), ("data_size", "I"),
        ("devices", "I"), ("name", "64s"), ("program_version", "16s"), ("user_name", "64s"), ("notes", "128s"),
    ],
    7300: [("size", "I"), ("version", "H"), ("records", "I"), ("", "I")],
}  # fmt: skip
CATALOGUE_ENTRY = np.dtype(
    [("size", "<u4"), ("offset", "<u8"), ("type", "<u2"), ("device", "<u2"), ("enumerator", "<u2"), ("time", "S10"),
     ("count", "<u4"), ("reserved", "<u2", 8)]
)  # fmt: skip
UNCOMPRESSED = 0x1002, "<f4"
LOGARITHMIC = 0x0006, "u1"
SIXTEEN_BIT = 0x0002, "<u2"
FACTOR_GIVEN = 0x2000


@dataclass
class Raw:
    """One record as the tables read it."""

    at: int
    frame: dict[str, Any]
    head: dict[str, Any]
    data: bytes
    optional: bytes

    @property
    def type(self) -> int:
        return int(self.frame["type"])


def read(path: Path) -> list[Raw]:
    """Read a whole file, every checksum checked."""
    content = path.read_bytes()
    found = []
    at = 0
    while at < len(content):
        raw = _record(content, at)
        found.append(raw)
        at += raw.frame["size"]
    return found


def instant(field: bytes) -> datetime:
    """Read a 7KTIME."""
    year, day, seconds, hours, minutes = struct.unpack("<HHfBB", field)
    return datetime(year, 1, 1, tzinfo=UTC) + timedelta(days=day - 1, hours=hours, minutes=minutes, seconds=seconds)


def samples(raw: Raw) -> Any:
    """Return the (beams, samples) magnitudes of a record 7018, or of a 7042 without phase and segments."""
    head = raw.head
    if raw.type == 7018:
        pairs = np.frombuffer(raw.data, "<u2").reshape(head["samples"], head["beams"], 2)
        return pairs[:, :, 0].T
    kind = dict((UNCOMPRESSED, LOGARITHMIC, SIXTEEN_BIT))
    dtype = kind[head["flags"] & ~FACTOR_GIVEN]
    beam = np.dtype([("number", "<u2"), ("count", "<u4"), ("data", dtype, head["compressed_samples"])])
    table = np.frombuffer(raw.data, beam)
    assert table["number"].tolist() == list(range(head["beams"]))
    assert set(table["count"]) == {head["compressed_samples"]}
    return table["data"]


def _record(content: bytes, at: int) -> Raw:
    frame = _fields(FRAME, content, at)
    assert (frame["version"], frame["sync"], frame["records"], frame["fragment"]) == (5, 0x0000FFFF, 0, 0)
    end = at + frame["size"] - 4
    assert sum(content[at:end]) % 2**32 == int.from_bytes(content[end : end + 4], "little")
    head_at = at + 4 + frame["offset"]
    layout = HEADS[frame["type"]]
    data_at = head_at + struct.calcsize(_format(layout))
    optional_at = at + frame["optional_at"] if frame["optional_at"] else end
    head = _fields(layout, content, head_at)
    return Raw(at, frame, head, content[data_at:optional_at], content[optional_at:end])


def _format(table: Table) -> str:
    return "<" + "".join(code for _, code in table)


def _fields(table: Table, content: bytes, at: int) -> dict[str, Any]:
    values = struct.unpack_from(_format(table), content, at)
    return {name: value for (name, _), value in zip(table, values, strict=True) if name}


def entries_of(path: Path) -> Any:
    """Return the catalogue's entries, found by the file header's optional data."""
    content = path.read_bytes()
    header = _record(content, 0)
    size, offset = struct.unpack("<IQ", header.optional)
    catalogue = _record(content, offset)
    assert (catalogue.type, catalogue.frame["size"]) == (7300, size)
    return np.frombuffer(catalogue.data, CATALOGUE_ENTRY)
