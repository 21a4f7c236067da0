"""Recordings in the 7k Data Format, .s7k. How they are written: test_recorder.py, test_record.py."""

from pathlib import Path

import pytest

from ods.sonar_link.files.opening import PingFileError, open_pings
from ods.sonar_link.files.s7k.catalogue import encode_file_header
from ods.sonar_link.files.s7k.writer import write_s7k
from ods.sonar_link.s7k.drf import DeviceId, encode_record
from tests.recordings import same_but
from tests.sonar_link.s7k_tables import entries_of
from tests.sonar_link.sonar_samples import UTC_NS, make_ping


def test_s7k_round_trip_with_foreign_records_and_a_cut_off_end(tmp_path: Path) -> None:
    path = tmp_path / "line.s7k"
    pings = [make_ping(n, utc_ns=UTC_NS + n * 250_000_000, samples=40 + n) for n in range(4)]
    write_s7k(path, pings)
    last = entries_of(path)[-1]
    data = path.read_bytes()[: last["offset"] + last["size"] - 7]
    assert data[4:8] == b"\xff\xff\x00\x00"
    path.write_bytes(data + encode_record(1003, bytes(37), UTC_NS, DeviceId(100)))
    sequence = open_pings(path)
    assert [same_but(a, b, "t_rx_ns", "setting") for a, b in zip(sequence.pings, pings[:3], strict=True)] == [True] * 3
    assert sequence.losses["bad_checksum"] == 1
    assert sequence.losses["other_records"] == 2
    assert sequence.timed


def test_s7k_without_pings_says_what_is_in_it(tmp_path: Path) -> None:
    path = tmp_path / "empty.s7k"
    path.write_bytes(encode_file_header(UTC_NS, "empty") + b"noise")
    with pytest.raises(PingFileError, match=r"no ping in it \(garbage_bytes 5, other_records 1, records 1\)"):
        open_pings(path)
