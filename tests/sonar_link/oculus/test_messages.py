"""The codec against bytes made by hand from the layouts, and against a real recording."""

import struct
from ipaddress import IPv4Address

import numpy as np
import pytest

from ods.base.arrays import AnyArray
from ods.sonar_link.oculus import image, messages
from ods.sonar_link.oculus.messages import Fire, MessageKind
from tests.recordings import OCULUS
from tests.sonar_link.oculus import wire


def frame(data: bytes) -> AnyArray:
    return image.amplitudes_of(messages.decode_ping_result(data), data)


def test_a_fire_message_of_the_first_version_byte_by_byte() -> None:
    fire = Fire(2, 1, 255, 127, 0x49, 25.0, 60.0, 1490.5, 35.0, extended_flags=0x200)
    expected = bytes.fromhex("534f 0000 0000 1500 0100 25000000 0000 0201ff7f49".replace(" ", ""))
    expected += struct.pack("<4d", 25.0, 60.0, 1490.5, 35.0)
    assert messages.encode_fire(fire, 1) == expected
    assert len(expected) == 53


def test_a_fire_message_of_the_second_version_adds_flags_and_reserve() -> None:
    fire = Fire(1, 0, 100, 255, 0x4B, 40.0, 50.0, 0.0, 0.0, extended_flags=0x200)
    data = messages.encode_fire(fire, 2)
    assert (len(data), data[8:14]) == (89, bytes.fromhex("020049000000"))
    assert data[53:] == bytes.fromhex("00020000") + bytes(32)


@pytest.mark.parametrize("version", [0, 1, 2])
def test_a_ping_result_of_either_version(version: int) -> None:
    sent = wire.image(1)
    data = wire.ping(sent, version, number=2**32 - 1, range=40.0, salinity=35.0)
    result = messages.decode_ping_result(data)
    assert (messages.unpack_header(data).kind, messages.unpack_header(data).size) == (MessageKind.PING, len(data))
    assert (result.ping_number, result.frequency_hz, result.sound_speed) == (2**32 - 1, 750e3, 1500.0)
    assert (result.lines, result.beams, result.dr_m, result.sample_bytes) == (5, 8, 0.05, 1)
    assert result.start_s == (100.0 if version == 2 else None)  # the first version's number has no known unit
    assert result.fire == Fire(1, 0, 255, 255, 0x49, 40.0, 50.0, 0.0, 35.0)
    assert messages.fits(result, len(data))
    np.testing.assert_array_equal(frame(data), sent.T)
    geometry = image.geometry_of(result, data)
    assert np.degrees(geometry.table.bearing_rad) == pytest.approx(np.arange(-100, 100, 25) / 100)
    assert (geometry.range0_m, geometry.dr_m) == pytest.approx((0.025, 0.05))


@pytest.mark.parametrize("gains", [False, True])
@pytest.mark.parametrize(("dtype", "reported"), [("u1", "u1"), ("<u2", "<u2"), ("<u4", "<f4")])
@pytest.mark.parametrize("version", [1, 2])
def test_samples_of_8_16_and_32_bits_with_and_without_gains(
    version: int, dtype: str, reported: str, gains: bool
) -> None:
    sent = wire.image(2, dtype=dtype)
    data = wire.ping(sent, version, gains=gains)
    decoded = frame(data)
    assert decoded.dtype == np.dtype(reported)
    np.testing.assert_array_equal(decoded, sent.T.astype(reported))


@pytest.mark.parametrize("dtype", ["u1", "<u2", "<u4"])
def test_gamma_is_undone_for_all_sample_types(dtype: str) -> None:
    sent = wire.image(3, dtype=dtype)
    full = float(np.iinfo(dtype).max)
    decoded = frame(wire.ping(sent, gamma=127))
    expected = full * (sent.T.astype(np.float64) / full) ** (255 / 127)
    np.testing.assert_allclose(decoded.astype(np.float64), expected, rtol=1e-6)
    assert decoded.dtype == np.float32


def test_samples_of_24_bits_are_refused() -> None:
    three = wire.ping(np.zeros((5, 24), np.uint8))
    data = bytearray(three)
    data[161] = 2
    struct.pack_into("<H", data, 172, 8)
    assert messages.fits(messages.decode_ping_result(data), len(data))
    with pytest.raises(ValueError, match="3 bytes"):
        frame(bytes(data))


def test_a_status_byte_by_byte() -> None:
    status = messages.decode_status(wire.status(client="192.168.2.10"))
    assert (status.device, status.part_number, status.state) == (7892, 1032, 3)
    assert (status.address, status.client) == (IPv4Address("192.168.2.3"), IPv4Address("192.168.2.10"))
    assert list(status.temperatures_c) == [20.0, 21.0, 22.0, 23.0, 24.0, 25.0, 31.5, 2.6e-76]
    assert status.pressure_bar == 1.25


@pytest.mark.parametrize("datagram", [b"", b"SO", bytes(142), wire.status()[:-1], wire.status() + b"x"])
def test_what_is_no_status_is_refused(datagram: bytes) -> None:
    with pytest.raises(ValueError, match="not a status"):
        messages.decode_status(datagram)


def test_the_real_recording_repeats_its_fire_message() -> None:
    result = messages.decode_ping_result(OCULUS.read_bytes()[:182016])
    assert result.fire[:6] == (2, 195, 25, 127, 0x19, 2.0)
    assert (result.fire.gain_percent, result.fire.salinity_ppt) == (50.0, 0.0)
    assert result.message_bytes == 182016
