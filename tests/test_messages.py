"""Messages survive the wire, and their documentation is current."""

from pathlib import Path

import msgspec
import numpy as np
import pytest

from ods.messages import Ping, frame_of
from ods.reference.pages import pages

DOCS = Path(__file__).parents[1] / "docs"


def ping(**changes: object) -> Ping:
    values: dict[str, object] = {
        "seq": 0, "ping_number": 1, "t_ns": 2, "t_rx_ns": 3, "utc_ns": 4, "beams": 2, "samples": 3, "dtype": "u2",
        "data": np.arange(6, dtype="<u2").tobytes(), "bearing_rad": [-0.1, 0.1], "range0_m": 1.0, "dr_m": 0.5,
        "sound_speed": 1500.0,
    }  # fmt: skip
    return msgspec.convert(values | changes, Ping)


@pytest.mark.parametrize("dtype", ["u1", "u2", "f4"])
def test_frame_survives_the_wire(dtype: str) -> None:
    frame = np.arange(6).reshape(2, 3).astype({"u1": "u1", "u2": "<u2", "f4": "<f4"}[dtype])
    sent = ping(dtype=dtype, data=frame.tobytes())
    received = msgspec.msgpack.decode(msgspec.msgpack.encode(sent), type=Ping)
    assert received == sent
    np.testing.assert_array_equal(frame_of(received), frame)


def test_a_buffer_of_the_wrong_length_is_refused() -> None:
    with pytest.raises(ValueError, match="5 bytes do not hold 2 x 3"):
        frame_of(ping(data=b"12345"))


@pytest.mark.parametrize("changes", [{"beams": 0}, {"samples": 10**9}, {"dtype": "f8"}, {"seq": -1}, {"planes": 0}])
def test_absurd_values_do_not_pass_the_wire(changes: dict[str, object]) -> None:
    with pytest.raises(msgspec.ValidationError):
        ping(**changes)


def test_generated_docs_are_current() -> None:
    for name, text in pages().items():
        assert (DOCS / name).read_text() == text, f"{name}: run `make docs`"
