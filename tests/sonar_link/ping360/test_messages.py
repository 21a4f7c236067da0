"""The codec against bytes made by hand, and against brping, the maker's own library."""

from typing import Any

import pytest
from hypothesis import given, strategies as st

from ods.sonar_link.ping360 import messages
from ods.sonar_link.ping360.messages import Beam, Kind, Sweep, Transmission
from tests.sonar_link.ping360 import wire

SWEEP = Sweep(start=350, stop=50, steps=1)


def test_a_beam_is_what_the_description_says() -> None:
    beam = messages.decode_beam(wire.auto_data(399, b"\x00\xff" * 100, sector=(340, 60), steps=2, period=1600, gain=2))
    assert beam == Beam(2, 399, 100, 1600, 750, Sweep(340, 60, 2), b"\x00\xff" * 100)
    assert messages.decode_beam(wire.device_data(5)).sweep is None


BEAMS = st.builds(
    Beam,
    gain=st.integers(0, 2),
    angle=st.integers(0, 399),
    pulse_us=st.integers(1, 1000),
    period=st.integers(80, 40000),
    frequency_khz=st.integers(500, 1000),
    sweep=st.one_of(
        st.none(),
        st.builds(Sweep, st.integers(0, 399), st.integers(0, 399), st.integers(1, 10), st.integers(0, 100)),
    ),
    samples=st.binary(min_size=1, max_size=1200),
)


@given(BEAMS)
def test_what_is_written_is_read(beam: Beam) -> None:
    assert messages.decode_beam(messages.encode_beam(beam)) == beam


@pytest.mark.parametrize(
    "spoilt",
    [
        wire.auto_data(400),
        wire.auto_data(sector=(400, 3)),
        wire.auto_data(steps=0),
        wire.auto_data(period=0),
        wire.auto_data(samples=b""),
        wire.auto_data(count=100),
        wire.auto_data()[:100],
    ],
)
def test_numbers_that_cannot_be_make_no_beam(spoilt: bytes) -> None:
    with pytest.raises(ValueError, match=r"samples|head"):
        messages.decode_beam(spoilt)


def test_refusals_and_what_the_device_says_it_is() -> None:
    refusal = wire.nack(2602, b"bad\x00 angle\n")
    assert (messages.decode_id(refusal), messages.decode_text(refusal)) == (2602, "bad angle")
    said = messages.decode_information(wire.message(4, bytes([2, 1, 3, 1, 1, 0])))
    assert said == (messages.PING360, 1, (3, 1, 1))


@pytest.fixture
def brping() -> Any:
    return pytest.importorskip("brping", reason="pip install bluerobotics-ping")


@given(beam=BEAMS.filter(lambda beam: beam.sweep is not None))
def test_brping_reads_our_beams(beam: Beam) -> None:
    brping = pytest.importorskip("brping", reason="pip install bluerobotics-ping")
    parser = brping.PingParser()
    states = [parser.parse_byte(byte) for byte in messages.encode_beam(beam)]
    assert states[-1] == parser.NEW_MESSAGE
    read, sweep = parser.rx_msg, beam.sweep
    assert sweep is not None
    assert (read.angle, read.gain_setting, read.sample_period) == (beam.angle, beam.gain, beam.period)
    assert (read.transmit_duration, read.transmit_frequency) == (beam.pulse_us, beam.frequency_khz)
    assert (read.start_angle, read.stop_angle, read.num_steps, read.delay) == tuple(sweep)
    assert (read.number_of_samples, bytes(read.data)) == (len(beam.samples), beam.samples)


def test_we_read_what_brping_packs(brping: Any) -> None:
    packed = brping.PingMessage(brping.definitions.PING360_AUTO_DEVICE_DATA)
    numbers = {
        "mode": 1, "gain_setting": 2, "angle": 123, "transmit_duration": 321, "sample_period": 4321,
        "transmit_frequency": 740, "start_angle": 350, "stop_angle": 50, "num_steps": 1, "delay": 7,
        "number_of_samples": 6, "data_length": 6, "data": bytes([0, 1, 2, 250, 66, 82]),
    }  # fmt: skip
    for name, value in numbers.items():
        setattr(packed, name, value)
    beam = messages.decode_beam(bytes(packed.pack_msg_data()))
    assert beam == Beam(2, 123, 321, 4321, 740, Sweep(350, 50, 1, 7), bytes([0, 1, 2, 250, 66, 82]))


def test_our_requests_are_those_of_brping(brping: Any) -> None:
    packed = brping.PingMessage(brping.definitions.PING360_AUTO_TRANSMIT)
    asked = Transmission(gain=1, pulse_us=133, period=1111, frequency_khz=750, samples=1200)
    numbers = ("mode", "gain_setting", "transmit_duration", "sample_period", "transmit_frequency", "number_of_samples",
               "start_angle", "stop_angle", "num_steps", "delay")  # fmt: skip
    for name, value in zip(numbers, (1, *asked, *SWEEP), strict=True):
        setattr(packed, name, value)
    assert messages.auto_transmit(asked, SWEEP) == bytes(packed.pack_msg_data())
    request = brping.PingMessage(brping.definitions.COMMON_GENERAL_REQUEST)
    request.requested_id = Kind.DEVICE_INFORMATION
    assert messages.general_request(Kind.DEVICE_INFORMATION) == bytes(request.pack_msg_data())
