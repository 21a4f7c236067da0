"""Norbit .wbms: the stream of the image port in a file; cut off, foreign and absurd."""

import struct
from pathlib import Path

import numpy as np
import pytest

from ods.messages import frame_of
from ods.sonar_link import sync_framer
from ods.sonar_link.files.opening import PingFileError, open_pings
from ods.sonar_link.norbit import packets
from tests.sonar_link.norbit import wire

PACKETS = [wire.image(wire.samples(number), number=number, time=1.7e9 + 0.1 * number) for number in range(1, 4)]


def written(path: Path, *parts: bytes | bytearray) -> Path:
    path.write_bytes(b"".join(parts))
    return path


def test_samples_times_and_numbers(tmp_path: Path) -> None:
    sequence = open_pings(written(tmp_path / "dive.bin", *PACKETS))  # known by what it holds
    assert [ping.ping_number for ping in sequence.pings] == [1, 2, 3]
    assert not sequence.losses
    assert sequence.timed
    np.testing.assert_array_equal(frame_of(sequence.pings[1]), wire.samples(2).T)
    assert sequence.pings[2].t_ns - sequence.pings[0].t_ns == pytest.approx(200_000_000, abs=1000)
    assert sequence.pings[0].range0_m == pytest.approx(0.5)


def test_cut_off_corrupt_and_foreign(tmp_path: Path) -> None:
    flipped = bytearray(PACKETS[1])
    flipped[250] ^= 1
    absurd = wire.image(wire.samples(4), rate=0.0)
    other = wire.sealed(bytes(88), 1)
    file = written(tmp_path / "dive.wbms", PACKETS[0], flipped, other, b"noise", absurd, PACKETS[2], PACKETS[0][:-5])
    sequence = open_pings(file)
    assert [ping.ping_number for ping in sequence.pings] == [1, 3]
    assert sequence.losses == {
        "corrupt_pings": 3, "other_messages": 1, "garbage_bytes": len(flipped) + 5 + len(PACKETS[0]) - 5
    }  # fmt: skip


@pytest.mark.parametrize(
    ("place", "code", "value"),
    [(32, "I", 0), (36, "I", 2**32 - 1), (48, "I", 99), (8, "I", 2**32 - 1), (8, "I", 0), (40, "d", float("nan")),
     (40, "d", -1.0), (28, "f", -1.0), (24, "f", 0.0)],
)  # fmt: skip
def test_absurd_numbers(tmp_path: Path, place: int, code: str, value: float) -> None:
    data = bytearray(PACKETS[0])
    struct.pack_into(f"<{code}", data, place, value)
    struct.pack_into("<I", data, 20, 0)  # no checksum tells
    with pytest.raises(PingFileError, match="no complete image of a Norbit WBMS"):
        open_pings(written(tmp_path / "bad.wbms", data))


def test_headers_within_headers_cost_few_checksums(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    checked = 0
    is_sound = packets.is_sound

    def counting(data: memoryview, header: packets.Header) -> bool:
        nonlocal checked
        checked += header.size
        return is_sound(data, header)

    monkeypatch.setattr(packets, "is_sound", counting)
    hostile = struct.pack("<4s3I4xI", packets.PREAMBLE, 1, 400_000, 1, 7) * 30_000
    file = written(tmp_path / "hostile.wbms", PACKETS[0], hostile, PACKETS[1], bytes(400_000), *PACKETS[1:])
    assert [ping.ping_number for ping in open_pings(file).pings][:1] == [1]
    assert checked < sync_framer.MAX_PACKET_BYTES + (sync_framer.CHECKED_AGAIN + 1) * file.stat().st_size
