"""Packets: real ones, made ones, and what is none."""

import zlib
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st

from ods.messages import frame_of
from ods.sonar_link.ping_builder import Stamp
from ods.sonar_link.sonar3d15 import packets
from ods.sonar_link.sonar3d15.image import ping_of
from ods.sonar_link.sonar3d15.unpack import snappy_block
from tests.sonar_link.sonar3d15 import wire

RECORDING = Path(__file__).parents[2] / "data" / "sonar3d15" / "ship_short.sonar"
STAMP = Stamp(0, 0, 0, 0)
BY_WLSONAR = {
    4448: (1480818483, 1716815835840639990, 51017148),
    4449: (58657049, 1716815836007098750, 51499385),
    4450: (3145479113, 1716815836173892170, 50463610),
    4451: (3711884324, 1716815836340519360, 51086552),
    4452: (1581209615, 1716815836507531710, 50108181),
    4453: (4099185191, 1716815836673508530, 51178708),
}
"""By sequence id: CRC-32 of the pixels as little-endian 16 bits row after row, time stamp, ns, and sum of the pixels,
as Water Linked's own client decodes the packet."""


def real_packets() -> list[bytes]:
    stream, at, found = RECORDING.read_bytes(), 0, []
    while at < len(stream):
        found.append(stream[at : at + packets.size_of(stream, at)])
        at += len(found[-1])
    return found


def test_real_range_images_are_those_that_the_makers_own_client_decodes() -> None:
    found = [packets.unpack(packet) for packet in real_packets()]
    assert [packet.kind for packet in found] == ["RangeImage", "BitmapImageGreyscale8"] * 6
    images = [packets.decode_range_image(packet.message) for packet in found if packet.kind == packets.RANGE_IMAGE]
    reported = {}
    for image in images:
        sent = np.ascontiguousarray(frame_of(ping_of(image, STAMP)).T)
        reported[image.number] = zlib.crc32(sent.tobytes()), image.time_ns, int(sent.sum())
    assert reported == BY_WLSONAR
    assert (images[0].width, images[0].height, images[0].range_m, images[0].sound_speed) == (256, 64, 15.0, 1491.0)


def test_every_field_of_a_made_packet() -> None:
    image = wire.pixels()
    found = packets.unpack(wire.packet(image, seq=77, opening=(40.0, 30.0)))
    ping = ping_of(packets.decode_range_image(found.message), STAMP)
    np.testing.assert_array_equal(frame_of(ping), image.T)
    assert ping.range_grid is not None
    np.testing.assert_allclose(np.degrees(ping.bearing_rad)[[0, -1]], [-20.0, 20.0])
    np.testing.assert_allclose(np.degrees(ping.range_grid.elevation_rad)[[0, -1]], [-15.0, 15.0])
    assert ping.dr_m == pytest.approx(0.001)
    assert (ping.range_grid.range_max_m, ping.frequency_hz) == (15.0, 1.2e6)
    assert packets.decode_range_image(found.message)[:2] == (1_716_815_835_840_000_000, 77)


def test_a_plain_packet_is_read_too() -> None:
    image = wire.pixels()
    plain = wire.sealed(wire.range_image(image), b"RIP1")
    assert packets.unpack(plain) == packets.unpack(wire.packet(image))


def test_snappy_copies_that_overlap_and_all_lengths() -> None:
    # "ab", then 9 bytes from 2 back, by each of the three kinds of copies; as format_description.txt has them
    for copy in (b"\x15\x02", b"\x22\x02\x00", b"\x23\x02\x00\x00\x00"):
        block = b"\x0b" + b"\x04ab" + copy
        assert snappy_block(block, 11) == b"abababababa"


@pytest.mark.parametrize(
    "block",
    [b"", b"\xff\xff\xff\xff\xff\x01", b"\x05\x04ab", b"\x02\x04a", b"\x0b\x04ab\x15\x03", b"\x0b\x04ab\x15\x00",
     b"\x03\x04ab\x15\x02", b"\x0c\x04ab\x15\x02", b"\x02\xf0", b"\x02\xfc\xff\xff\xff\xff", b"\x7f" + b"\x04ab"],
)  # fmt: skip
def test_damaged_blocks_are_refused(block: bytes) -> None:
    with pytest.raises(ValueError, match="snappy"):
        snappy_block(block, 100)


def test_a_block_that_claims_too_much_is_refused_before_memory_is_taken() -> None:
    with pytest.raises(ValueError, match="4294967295 bytes in it, more than 262028"):
        packets.unpack(wire.sealed(wire.varint(2**32 - 1) + bytes(10)))


@pytest.mark.parametrize(
    "reported",
    [{"size": (32, 9)}, {"size": (0, 0)}, {"size": (1, 256)}, {"size": (2**31, 2**31)}, {"scale": 0.0},
     {"scale": float("nan")}, {"scale": -1.0}, {"sound": 0.0}, {"reach": float("inf")}, {"reach": 0.0},
     {"opening": (0.0, 40.0)}, {"opening": (90.0, float("nan"))}, {"opening": (90.0, 400.0)},
     {"packed": wire.varint(70_000) * 256}, {"packed": b"\x80" * 300}, {"packed": b""}],
)  # fmt: skip
def test_absurd_numbers_make_no_ping(reported: dict[str, object]) -> None:
    found = packets.unpack(wire.packet(wire.pixels(), **reported))
    with pytest.raises(ValueError, match=r"\w"):
        ping_of(packets.decode_range_image(found.message), STAMP)


@given(st.binary(max_size=200))
def test_any_bytes_are_a_message_or_refused(content: bytes) -> None:
    for name in (b"RIP1", b"RIP2"):
        try:
            packets.decode_range_image(packets.unpack(wire.sealed(content, name)).message)
        except ValueError:
            continue


@given(st.integers(0, 2000), st.integers(0, 255))
def test_a_wrong_byte_in_a_good_message_is_a_ping_or_refused(place: int, value: int) -> None:
    content = bytearray(wire.range_image(wire.pixels(width=16)))
    content[place % len(content)] = value
    try:
        image = packets.decode_range_image(packets.unpack(wire.sealed(bytes(content), b"RIP1")).message)
        assert frame_of(ping_of(image, STAMP)).size == image.width * image.height
    except ValueError:
        return
