"""TTM: fields computed by hand, read back by pynmea2; numbers of targets that stay and that are given back."""

import pynmea2
import pytest

from ods.bridge.settings import TtmSettings
from ods.bridge.ttm import TtmEncoder
from tests.bridge.samples import ENDED, ROCK, SWIMMER, moment, obstacle

SETTINGS = TtmSettings(to="udp://127.0.0.1:10110")


def said(encoder: TtmEncoder, *obstacles: object, **more: object) -> list[list[str]]:
    """Return the fields of each sentence, once pynmea2 has checked its checksum."""
    datagrams = encoder.encode(moment(*obstacles, **more)).datagrams  # type: ignore[arg-type]
    assert all(data.endswith(b"\r\n") and len(data) <= 82 for data in datagrams)
    return [pynmea2.parse(data.decode(), check=True).data for data in datagrams]


def test_fields_are_true_bearings_nautical_miles_and_knots() -> None:
    rock, swimmer = said(TtmEncoder(SETTINGS), SWIMMER, ENDED, ROCK)
    # 27 m = 0.01458 nm to the edge, due east; at rest; CPA 18.52 m = 0.01 nm in 60 s = 1 min
    assert rock == [
        "00", "0.0146", "090.0", "T", "0.00", "000.0", "T", "0.0100", "1.00", "N", "ODS7", "T", "", "030406.50", "A",
    ]  # fmt: skip
    # 10 m north, 67 m east: 67.74 m - 2 m = 0.0355 nm, 81.5 deg; 2 m/s = 3.89 kn to the west
    assert swimmer[:7] == ["01", "0.0355", "081.5", "T", "3.89", "270.0", "T"]
    assert swimmer[7:] == ["", "", "N", "ODS300", "T", "", "030406.50", "A"]


def test_the_sentence_is_that_of_a_radar_unless_another_talker_is_set() -> None:
    assert TtmEncoder(SETTINGS).encode(moment(ROCK)).datagrams[0].startswith(b"$RATTM,00,")
    sounder = TtmSettings(to=SETTINGS.to, talker="SS")
    assert TtmEncoder(sounder).encode(moment(ROCK)).datagrams[0].startswith(b"$SSTTM,00,")


def test_utc_that_is_not_to_be_relied_on_is_not_reported() -> None:
    (rock,) = said(TtmEncoder(SETTINGS), ROCK, utc_source="unsure")
    assert rock[13] == ""


def test_a_bearing_of_just_below_360_is_0() -> None:
    (ahead,) = said(TtmEncoder(SETTINGS), obstacle(1, 200.0, 20.99))
    assert ahead[2] == "000.0"


def test_within_an_obstacle_the_distance_is_0() -> None:
    (around,) = said(TtmEncoder(SETTINGS), obstacle(1, 100.0, 21.5))
    assert around[1] == "0.0000"


def test_numbers_stay_and_what_leaves_is_lost_once() -> None:
    encoder = TtmEncoder(SETTINGS)
    assert [each[0] for each in said(encoder, ROCK, SWIMMER)] == ["00", "01"]
    lost, swimmer = said(encoder, SWIMMER)
    assert (lost[0], lost[11], swimmer[0]) == ("00", "L", "01")
    swimmer, new = said(encoder, SWIMMER, obstacle(301, 500.0, 500.0))
    assert (swimmer[0], swimmer[11], new[0]) == ("01", "T", "02")  # the number just lost comes again last


@pytest.mark.parametrize("rounds", [1, 50])
def test_numbers_never_run_out(rounds: int) -> None:
    encoder = TtmEncoder(TtmSettings(to=SETTINGS.to, most_obstacles=100))
    for turn in range(rounds):
        each = [obstacle(turn * 150 + number, 100.0, 30.0 + number) for number in range(150)]
        encoded = encoder.encode(moment(*each))
        tracked = [line.split(b",") for line in encoded.datagrams if b",L," not in line]
        assert len({fields[1] for fields in tracked}) == len(tracked) == 100
        assert encoded.left_out == 50
