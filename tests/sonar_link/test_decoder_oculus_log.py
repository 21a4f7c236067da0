"""Logs of Oculus ViewPoint, made from the layout: the stream's pings, with times; packed, cut off, absurd."""

import struct
import zlib
from pathlib import Path

import pytest

from ods.base.clock import NS
from ods.messages import frame_of
from ods.sonar_link.files.opening import PingFileError, open_pings
from tests.recordings import OCULUS

MESSAGE_BYTES = 182_016
BEGUN_S = 1_700_000_000.25


NO_HEAD = struct.pack("<II", 0xAABBCCDD, 0) + bytes(32)
"""An item that says that it has no bytes: the next one would be it again."""


def messages() -> list[bytes]:
    data = OCULUS.read_bytes()
    return [data[at : at + MESSAGE_BYTES] for at in range(0, len(data), MESSAGE_BYTES)]


def file_head(encryption: int = 0) -> bytes:
    head = struct.pack("<II", 0x11223344, 48) + b"Oculus".ljust(16, b"\0") + struct.pack("<HH", 1, encryption)
    return head + bytes(4) + struct.pack("<qd", 0, BEGUN_S)


def item(kind: int, payload: bytes, time_s: float, compression: int = 0, original: int | None = None) -> bytes:
    head = struct.pack("<IIHH", 0xAABBCCDD, 40, kind, 2) + bytes(4) + struct.pack("<dH", time_s, compression)
    size = len(payload) if original is None else original
    return head + bytes(2) + struct.pack("<II", size, len(payload)) + bytes(4) + payload


def packed(data: bytes) -> bytes:
    return len(data).to_bytes(4, "big") + zlib.compress(data)


def log(path: Path, *items: bytes, head: bytes | None = None) -> Path:
    path.write_bytes((file_head() if head is None else head) + b"".join(items))
    return path


def test_the_pings_are_those_of_the_stream_with_their_times(tmp_path: Path) -> None:
    first, second, third = messages()
    path = log(
        tmp_path / "mission.oculus",
        item(1, b"settings", BEGUN_S), item(10, first, BEGUN_S + 1.0),
        item(10, packed(second), BEGUN_S + 1.1, 1, len(second)), item(500, b"view", BEGUN_S + 1.15),
        item(10, third, BEGUN_S + 1.2),
    )  # fmt: skip
    found, stream = open_pings(path), open_pings(OCULUS)
    assert found.timed
    assert [ping.ping_number for ping in found.pings] == [415323, 415324, 415325]
    assert [ping.t_ns / NS for ping in found.pings] == pytest.approx([BEGUN_S + 1.0, BEGUN_S + 1.1, BEGUN_S + 1.2])
    for ping, same in zip(found.pings, stream.pings, strict=True):
        assert frame_of(ping).tobytes() == frame_of(same).tobytes()
        assert (ping.bearing_rad, ping.dr_m, ping.range0_m) == (same.bearing_rad, same.dr_m, same.range0_m)
    assert found.losses == {"other_messages": 2}


def test_a_log_that_was_cut_off_or_is_damaged_gives_what_is_whole(tmp_path: Path) -> None:
    first, second, third = messages()
    bomb = packed(bytes(50_000_000))
    path = log(
        tmp_path / "bad.oculus",
        item(10, first, BEGUN_S), NO_HEAD, b"noise",
        item(10, second, float("nan")), item(10, bomb, BEGUN_S, 1), item(10, packed(second)[:1000], BEGUN_S, 1),
        item(10, second[:5000], BEGUN_S), item(10, second, BEGUN_S, 7), item(10, b"", BEGUN_S),
        item(10, third, BEGUN_S)[:-5],
    )  # fmt: skip
    found = open_pings(path)
    assert [ping.ping_number for ping in found.pings] == [415323]
    assert found.losses["corrupt_pings"] == 6
    assert found.losses["garbage_bytes"] == 40 + 5 + 40 + MESSAGE_BYTES - 5


@pytest.mark.parametrize(
    ("head", "said"),
    [
        (file_head()[:20], "not an Oculus View"),
        (file_head(), "no complete simple ping"),
        (file_head(1), "encrypted"),
    ],
)
def test_what_is_no_log_is_one_line(tmp_path: Path, head: bytes, said: str) -> None:
    with pytest.raises(PingFileError, match=said) as error:
        open_pings(log(tmp_path / "x.oculus", head=head))
    assert "\n" not in str(error.value)
