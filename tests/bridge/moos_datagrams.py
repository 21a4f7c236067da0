"""The datagrams of MOOS's pShare, read and written for tests by what CMOOSMsg::Serialize of moos-ivp a2a9b716c does."""

import struct
from typing import NamedTuple


class MoosMessage(NamedTuple):
    """The fields in their order on the wire, behind the length."""

    number: int
    kind: str
    data_kind: str
    source: str
    source_aux: str
    community: str
    key: str
    time_s: float
    value: float
    value_2: float
    text: str


def read(data: bytes) -> MoosMessage:
    """Return what a datagram says; it must be as long as it says itself."""
    (length, number), place = struct.unpack_from("<ii", data), 8
    assert length == len(data)
    kinds = data[8:10].decode()
    place = 10
    texts: list[str] = []
    for _ in range(4):
        text, place = _text(data, place)
        texts.append(text)
    time_s, value, value_2 = struct.unpack_from("<ddd", data, place)
    text, place = _text(data, place + 24)
    assert place == len(data)
    return MoosMessage(number, kinds[0], kinds[1], texts[0], texts[1], texts[2], texts[3], time_s, value, value_2, text)


def _text(data: bytes, place: int) -> tuple[str, int]:
    (length,) = struct.unpack_from("<i", data, place)
    return data[place + 4 : place + 4 + length].decode(), place + 4 + length


def written(key: str, value: float | str, time_s: float) -> bytes:
    """Return the datagram of a number, such as NAV_X, or of a text."""
    text, number = (value.encode(), -1.0) if isinstance(value, str) else (b"", value)
    texts = b"".join(struct.pack("<i", len(name)) + name for name in (b"test", b"", b"test", key.encode()))
    body = struct.pack("<icc", -1, b"N", b"S" if text else b"D") + texts
    body += struct.pack("<dddi", time_s, number, -1.0, len(text)) + text
    return struct.pack("<i", 4 + len(body)) + body
