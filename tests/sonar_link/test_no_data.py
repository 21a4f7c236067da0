"""What the decoders tell of samples that hold no data, and that recordings keep it."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from ods.base.arrays import SAMPLE_DTYPES
from ods.messages import Ping
from ods.sonar_link.files.npz_writer import write_ping_file
from ods.sonar_link.files.opening import open_pings
from ods.sonar_link.files.ping_sequence import PingFileError
from ods.sonar_link.s7k import records
from tests.sonar_link.sonar_samples import link, make_ping

GAPS = [(1, 25, 40), (3, 0, 40), (4, 39, 40)]


def gappy(dtype: str, **changes: object) -> Ping:
    ping = make_ping(1, beams=6, samples=40)
    frame = np.arange(1, 241).reshape(6, 40).astype(SAMPLE_DTYPES[dtype])
    for beam, first, stop in GAPS:
        frame[beam, first:stop] = 0
    fields = {"dtype": dtype, "data": frame.tobytes(), "no_data": GAPS} | changes
    return msgspec.structs.replace(ping, **fields)


@pytest.mark.parametrize(
    "ping", [gappy("u1", scale="log8", scale_factor=40.0), gappy("u2", scale="linear"), gappy("f4", scale="linear")]
)
def test_beams_cut_short_in_record_7042_are_reported(ping: Ping) -> None:
    (received,), _ = link([records.encode_ping(ping)])
    assert (received.data, received.no_data) == (ping.data, GAPS)


def test_recorded_pings_keep_their_gaps(tmp_path: Path) -> None:
    pings = [gappy("u1", scale="log8", scale_factor=40.0, seq=k, t_ns=k * 10**8) for k in range(3)]
    pings[1] = msgspec.structs.replace(pings[1], no_data=[])
    write_ping_file(tmp_path / "pings.npz", pings)
    assert [ping.no_data for ping in open_pings(tmp_path / "pings.npz").pings] == [GAPS, [], GAPS]


def test_gaps_that_a_file_s_frames_do_not_have_are_refused(tmp_path: Path) -> None:
    pings = [gappy("u1", scale="log8", scale_factor=40.0, no_data=[(6, 0, 40)])]
    write_ping_file(tmp_path / "pings.npz", pings)
    with pytest.raises(PingFileError, match="no_data"):
        open_pings(tmp_path / "pings.npz")
