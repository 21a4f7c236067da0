"""What each bridge does with an obstacle that an operator said to ignore, as docs/tracker/veto.md has it."""

import json

import msgspec
import pytest

from ods.bridge.json_udp import JsonEncoder
from ods.bridge.moos import MoosEncoder
from ods.bridge.ros2 import content
from ods.bridge.settings import JsonSettings, MoosSettings, TtmSettings
from ods.bridge.ttm import TtmEncoder
from ods.messages import Veto, VetoRegion
from ods.ros2.markers import GREY, ORANGE
from ods.ros2.messages import Messages
from ods.runtime.caution import cautions
from tests.bridge.samples import ROCK, SWIMMER, UTC_NS, moment

TO = "udp://127.0.0.1:10110"
VETO = Veto(
    number=4, author="anna", reason="our buoy", until_ns=0, until_utc_ns=UTC_NS, id=7,
    region=VetoRegion(centre_ne=(100.0, 50.0), radius_m=4.0),
)  # fmt: skip
IGNORED = msgspec.structs.replace(ROCK, ignored_by=4)
MOMENT = moment(IGNORED, SWIMMER, vetoes=[VETO])
MAKE = Messages()


def test_json_says_by_whom_why_and_until_when() -> None:
    (datagram,) = JsonEncoder(JsonSettings(to=TO)).encode(MOMENT).datagrams
    ignored = {each["id"]: each["ignored"] for each in json.loads(datagram)["obstacles"]}
    assert ignored == {7: {"by": "anna", "why": "our buoy", "until_utc_ms": UTC_NS // 1_000_000}, 300: None}


def test_moos_is_not_given_it_and_counts_it_as_left_out() -> None:
    encoded = MoosEncoder(MoosSettings(to=TO)).encode(MOMENT)
    assert [b"label=ods_300" in each for each in encoded.datagrams] == [True]
    assert encoded.left_out == 1


def test_ttm_names_it_so() -> None:
    rock, swimmer = TtmEncoder(TtmSettings(to=TO)).encode(MOMENT).datagrams
    assert b",IGN7," in rock
    assert b",ODS300," in swimmer


@pytest.mark.parametrize(("key", "field"), [("obstacles", "obstacles"), ("tracks", "tracks")])
def test_messages_of_ros_that_cannot_say_it_are_without_it(key: str, field: str) -> None:
    made = content.OF_LISTS[key](MAKE, UTC_NS, content.now(MOMENT, 10))
    assert len(getattr(made, field)) == 1


def test_markers_of_ros_are_grey() -> None:
    made = content.OF_LISTS["markers"](MAKE, UTC_NS, content.now(MOMENT, 10))
    colours = {each.id: (each.color.r, each.color.g, each.color.b) for each in made.markers if each.ns == "obstacles"}
    assert (colours[7], colours[300]) == (GREY, ORANGE)


def test_screens_say_it_once_for_each_veto() -> None:
    assert cautions(MOMENT.obstacle_list) == ["7 ignored by anna until 03:04:05 UTC: our buoy"]
