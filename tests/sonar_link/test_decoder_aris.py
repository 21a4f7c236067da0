"""SoundMetrics .aris: a real recording against its maker's figures; cut off and corrupt."""

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from ods.messages import frame_of
from ods.sonar_link.files.opening import PingFileError, open_pings
from tests.recordings import ARIS, edited


def test_aris_samples_beams_and_ranges() -> None:
    sequence = open_pings(ARIS)
    raw = ARIS.read_bytes()
    assert len(sequence.pings) == 6
    assert not sequence.losses
    ping = sequence.pings[2]
    frame_at = 1024 + 2 * (1024 + 2000 * 48) + 1024
    assert [frame_of(ping)[47, 0], frame_of(ping)[0, 0], frame_of(ping)[46, 1999]] == [
        raw[frame_at], raw[frame_at + 47], raw[frame_at + 1999 * 48 + 1]
    ]  # fmt: skip
    # 4593 us delay and 14 us a sample at 1435.933 m/s
    assert (ping.range0_m, ping.dr_m) == pytest.approx((3.297621, 0.01005153), rel=1e-6)
    assert (ping.scale, ping.scale_factor, ping.frequency_hz) == ("db", 80 / 255, 1.2e6)
    assert [p.t_ns for p in sequence.pings][:2] == [1371198079122519000, 1371198079274984000]
    # beam centres of the telephoto lens as its maker publishes them, degrees
    bearing = np.degrees(ping.bearing_rad)
    assert bearing[[0, 1, 12, 23, 24, 47]] == pytest.approx([-7.339, -7.043, -3.659, -0.160, 0.160, 7.339], abs=0.004)
    assert np.all(np.diff(bearing) > 0.28)


def test_aris_cut_off_and_corrupt(tmp_path: Path) -> None:
    frame = 1024 + 2000 * 48

    def spoil(data: bytearray) -> None:
        data[1024 + 1 * frame + 12] = 0  # signature
        struct.pack_into("<f", data, 1024 + 2 * frame + 464, float("nan"))  # sound speed
        struct.pack_into("<I", data, 1024 + 3 * frame + 468, 2**32 - 1)  # samples
        struct.pack_into("<I", data, 1024 + 4 * frame + 452, 0)  # sample period
        del data[-100:]

    sequence = open_pings(edited(tmp_path / "bad.aris", ARIS, spoil))
    assert [p.t_ns for p in sequence.pings] == [1371198079122519000]
    assert sequence.losses == {"corrupt_frames": 4, "truncated_frames": 1}


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda data: data.__delitem__(slice(1500, None)), "not an ARIS recording"),
        (lambda data: data.__delitem__(slice(5000, None)), "no complete frame"),
        (lambda data: struct.pack_into("<I", data, 1024 + 468, 2**32 - 1), "first frame header is corrupt"),
        (lambda data: struct.pack_into("<I", data, 1024 + 436, 77), "first frame header is corrupt"),
        (lambda data: struct.pack_into("<I", data, 1024 + 436, 6), "first frame header is corrupt"),
    ],
)
def test_aris_errors(tmp_path: Path, edit: Callable[[bytearray], object], message: str) -> None:
    with pytest.raises(PingFileError, match=message):
        open_pings(edited(tmp_path / "bad.aris", ARIS, edit))
