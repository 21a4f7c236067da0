"""Water Linked .sonar: packets in a file; cut off, foreign and damaged."""

from pathlib import Path

import numpy as np
import pytest

from ods.messages import frame_of
from ods.sonar_link.files.npz_writer import write_ping_file
from ods.sonar_link.files.opening import PingFileError, open_pings
from ods.sonar_link.files.s7k.writer import write_s7k
from tests.sonar_link.sonar3d15 import wire
from tests.sonar_link.sonar3d15.test_packets import RECORDING

PACKETS = [wire.packet(wire.pixels(number), seq=number) for number in range(1, 4)]


def written(path: Path, *parts: bytes | bytearray) -> Path:
    path.write_bytes(b"".join(parts))
    return path


def test_a_real_recording_of_a_ships_hull() -> None:
    sequence = open_pings(RECORDING)
    assert [ping.ping_number for ping in sequence.pings] == list(range(4448, 4454))
    assert sequence.losses == {"other_messages": 6}
    steps_s = np.diff([ping.t_ns for ping in sequence.pings]) / 1e9
    np.testing.assert_allclose(steps_s, 0.167, atol=0.002)
    shares = [np.count_nonzero(frame_of(ping)) / frame_of(ping).size for ping in sequence.pings]
    assert 0.61 < min(shares) < max(shares) < 0.68


def test_cut_off_damaged_and_foreign(tmp_path: Path) -> None:
    flipped = bytearray(PACKETS[1])
    flipped[100] ^= 1
    absurd = wire.packet(wire.pixels(), size=(9, 9))
    other = wire.sealed(wire.literals(wire.message("ImuBatch", b"")))
    file = written(tmp_path / "a", PACKETS[0], flipped, b"noise", absurd, other, PACKETS[2], PACKETS[0][:-5])
    sequence = open_pings(file)
    assert [ping.ping_number for ping in sequence.pings] == [1, 3]
    assert sequence.losses == {
        "corrupt_pings": 3, "other_messages": 1, "garbage_bytes": len(flipped) + 5 + len(PACKETS[0]) - 5
    }  # fmt: skip


def test_no_image_in_it(tmp_path: Path) -> None:
    with pytest.raises(PingFileError, match="no complete range image of a Sonar 3D-15 in it"):
        open_pings(written(tmp_path / "a.sonar", b"RIP2" + bytes(100)))


def test_other_formats_refuse_to_keep_ranges_as_levels(tmp_path: Path) -> None:
    pings = [*open_pings(RECORDING).pings]
    with pytest.raises(ValueError, match="range image"):
        write_ping_file(tmp_path / "a.npz", pings)
    with pytest.raises(ValueError, match="range image"):
        write_s7k(tmp_path / "a.s7k", pings)
