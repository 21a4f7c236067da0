"""JSON: places, distances and headings computed by hand; never longer than a datagram may be."""

import json
import math

import pytest

from ods.bridge.json_udp import JsonEncoder, heading_deg
from ods.bridge.settings import JsonSettings
from ods.messages import UnseenPart
from tests.bridge.samples import ENDED, ROCK, SWIMMER, UTC_NS, moment, obstacle

SETTINGS = JsonSettings(to="udp://127.0.0.1:5005")


def test_places_are_those_of_the_instant_of_sending() -> None:
    part = UnseenPart(-0.5, 0.25, 10.0, 20.0, "saturated")
    encoded = JsonEncoder(SETTINGS).encode(moment(SWIMMER, ENDED, ROCK, left_out=4, unseen=[part], unseen_share=0.1))
    (datagram,) = encoded.datagrams
    reported = json.loads(datagram)
    assert reported["utc_ms"] == UTC_NS // 1_000_000 + 1000
    assert (reported["age_s"], reported["seq"], reported["frame"]) == (1.0, 3, "ned")
    assert reported["site"] == {"latitude_deg": 57.0, "longitude_deg": 10.0}
    assert reported["vehicle"]["position_ned"] == [100.0, 21.0, 5.0]
    assert reported["vehicle"]["velocity_ned"] == [0.0, 2.0, 0.0]
    assert reported["vehicle"]["heading_deg"] == 90.0
    rock, swimmer = reported["obstacles"]
    assert (rock["id"], rock["position_ned"]) == (7, [100.0, 50.0, 5.0])
    assert rock["distance_m"] == 29.0 - 2.0  # 50 m - 21 m east, less the radius
    assert rock["cpa"] == {"time_s": 60.0, "distance_m": 18.52, "sigma_m": 0.5}
    assert (swimmer["id"], swimmer["position_ned"]) == (300, [110.0, 88.0, 5.0])
    assert swimmer["distance_m"] == round(math.hypot(10.0, 67.0) - 2.0, 3)
    assert swimmer["cpa"] is None
    assert reported["unseen"] == [{"bearing_deg": [-28.648, 14.324], "range_m": [10.0, 20.0], "why": "saturated"}]
    assert reported["left_out"] == encoded.left_out == 4


@pytest.mark.parametrize("most_bytes", [1000, 1472, 65_000])
def test_a_datagram_is_bounded_by_leaving_out_the_farthest(most_bytes: int) -> None:
    settings = JsonSettings(to=SETTINGS.to, most_bytes=most_bytes, most_obstacles=100)
    many = [obstacle(number, 100.0 + 1e-7 * number, 1000.0 - 3.1234567 * number) for number in range(200)]
    words = {"unseen_why": "w" * 9999, "caution": "c" * 9999} if most_bytes > 1472 else {}
    encoded = JsonEncoder(settings).encode(moment(*many, **words))
    reported = json.loads(encoded.datagrams[0])
    sent = [each["id"] for each in reported["obstacles"]]
    assert len(encoded.datagrams[0]) <= most_bytes
    assert sent == list(range(199, 199 - len(sent), -1))
    assert reported["left_out"] == encoded.left_out == 200 - len(sent)
    assert len(sent) == 100 if most_bytes == 65_000 else 1 <= len(sent) < 4


def test_what_is_no_number_is_left_out_and_counted() -> None:
    nowhere = obstacle(9, math.nan, 0.0)
    encoded = JsonEncoder(SETTINGS).encode(moment(nowhere, ROCK))
    assert [each["id"] for each in json.loads(encoded.datagrams[0])["obstacles"]] == [7]
    assert encoded.left_out == 1


@pytest.mark.parametrize("heading", [0.0, 1.0, 89.0, 179.0, 181.0, 359.0])
def test_a_heading_is_clockwise_from_north(heading: float) -> None:
    half = math.radians(heading) / 2.0
    assert heading_deg((math.cos(half), 0.0, 0.0, math.sin(half))) == pytest.approx(heading)
