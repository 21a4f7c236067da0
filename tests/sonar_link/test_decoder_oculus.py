"""Blueprint Oculus .raw: a real recording against its bytes; cut off, foreign and absurd."""

import struct
from pathlib import Path

import numpy as np
import pytest

from ods.base.arrays import Bytes
from ods.messages import frame_of
from ods.sonar_link.files.opening import PingFileError, open_pings
from tests.recordings import OCULUS, edited


def raw_oculus(index: int) -> Bytes:
    """The samples of one message, beam by beam: 703 lines of 256 beams at byte 2048 of 182016."""
    return np.fromfile(OCULUS, np.uint8, 703 * 256, offset=index * 182016 + 2048).reshape(703, 256).T


def test_oculus_samples_beams_and_ranges() -> None:
    sequence = open_pings(OCULUS)
    assert [p.ping_number for p in sequence.pings] == [415323, 415324, 415325]
    assert not sequence.losses
    assert not sequence.timed
    ping = sequence.pings[1]
    # the sonar sent the power 127/255 of the amplitude
    expected = 255.0 * (raw_oculus(1) / 255.0) ** (255 / 127)
    np.testing.assert_allclose(frame_of(ping).astype(np.float64), expected, rtol=1e-6)
    assert (ping.scale, ping.dtype, ping.beams, ping.samples) == ("linear", "f4", 256, 703)
    assert np.degrees(ping.bearing_rad)[[0, 1, 255]] == pytest.approx([-30.0, -29.74, 30.0])
    assert ping.dr_m == pytest.approx(2.84219e-3, rel=1e-5)
    assert ping.range0_m == pytest.approx(ping.dr_m / 2)
    assert (ping.sound_speed, ping.frequency_hz) == pytest.approx((1490.6586, 2.0988806e6))


def test_oculus_without_gamma_stays_8_bit(tmp_path: Path) -> None:
    path = edited(tmp_path / "plain.raw", OCULUS, lambda data: data.__setitem__(16 + 3, 255))
    ping = open_pings(path).pings[0]
    assert ping.dtype == "u1"
    assert frame_of(ping).tolist() == raw_oculus(0).tolist()


def test_a_file_that_is_only_cut_off_has_no_other_losses(tmp_path: Path) -> None:
    path = edited(tmp_path / "cut.raw", OCULUS, lambda data: data.__delitem__(slice(182016 + 1000, None)))
    assert dict(open_pings(path).losses) == {"garbage_bytes": 1000}


def test_oculus_cut_off_corrupt_and_foreign(tmp_path: Path) -> None:
    def spoil(data: bytearray) -> None:
        struct.pack_into("<H", data, 182016 + 106, 65535)  # lines of the second ping
        data[2 * 182016 : 2 * 182016] = struct.pack("<2sHHHHIH", b"SO", 0, 0, 0x55, 0, 12, 0) + bytes(12) + b"noise"
        del data[-5:]

    sequence = open_pings(edited(tmp_path / "bad.raw", OCULUS, spoil))
    assert [p.ping_number for p in sequence.pings] == [415323]
    assert sequence.losses["corrupt_pings"] == 1
    assert sequence.losses["other_messages"] == 1
    assert sequence.losses["garbage_bytes"] == 182016 + 5 + 182016 - 5  # the corrupt ping, the noise, the cut-off ping


@pytest.mark.parametrize(
    ("offset", "value"),
    [
        (106, 0), (106, 65535), (108, 0), (108, 65535),  # lines, beams
        (110, 2**32 - 1), (110, 0), (114, 2**32 - 1),  # image offset, image size
        (97, 7), (104, 0x7FF8), (122, 9000),  # sample size, line spacing (to NaN), first bearing (to 90 degrees)
    ],
)  # fmt: skip
def test_oculus_absurd_sizes(tmp_path: Path, offset: int, value: int) -> None:
    def spoil(data: bytearray) -> None:
        del data[182016:]
        struct.pack_into("<I" if offset in (110, 114) else "<H" if offset != 97 else "<B", data, offset, value)

    with pytest.raises(PingFileError, match="no complete simple ping result"):
        open_pings(edited(tmp_path / "bad.raw", OCULUS, spoil))
