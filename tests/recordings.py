"""Recordings for the tests of the decoders: the real ones, damaged copies of them, and pings that come back."""

from collections.abc import Callable
from pathlib import Path

from ods.messages import Ping

DATA = Path(__file__).parent / "data"
ARIS = DATA / "aris" / "sample.aris"
OCULUS = DATA / "oculus" / "three_pings_8bit.raw"


def edited(path: Path, source: Path, edit: Callable[[bytearray], object]) -> Path:
    data = bytearray(source.read_bytes())
    edit(data)
    path.write_bytes(data)
    return path


def same_but(a: Ping, b: Ping, *fields: str) -> bool:
    return all(getattr(a, name) == getattr(b, name) for name in Ping.__struct_fields__ if name not in fields)
