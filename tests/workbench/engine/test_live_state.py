"""Vetoes and bridges in words, of lists and health as the tracker and the bridges send them."""

import msgspec

from ods.base.clock import NS
from ods.messages import Health, Veto, VetoRegion
from ods.workbench.engine.live_state import bridges, named, vetoes
from tests.export import mission

replace = msgspec.structs.replace
PIER = VetoRegion(corners_ne=[(0.0, 0.0), (0.0, 10.0), (10.0, 10.0)], down_m=(2.0, 8.0))


def test_a_veto_tells_who_why_how_long_and_what_is_ignored_by_it_now() -> None:
    reported = mission.LIST
    first, *others = reported.obstacles
    around = VetoRegion(centre_ne=(40.0, 5.0), radius_m=8.0)
    both = [
        Veto(number=number, author="anna", reason="our buoy", until_ns=reported.t_ns + 90 * NS,
             until_utc_ns=reported.utc_ns + 90 * NS, region=region, id=identity)
        for number, region, identity in ((3, around, first.id), (4, PIER, None))
    ]  # fmt: skip
    held = vetoes(replace(reported, obstacles=[replace(first, ignored_by=3), *others], vetoes=both))
    assert [(each.number, each.ignored, each.author, each.left_s) for each in held] == [
        (3, [first.id], "anna", 90.0), (4, [], "anna", 90.0),
    ]  # fmt: skip
    assert held[0].what == f"obstacle {first.id}, while it is within 8.0 m around 40.0 north, 5.0 east"


def test_a_region_is_named_with_its_depths() -> None:
    assert named(None, PIER) == "what rests within a polygon of 3 corners, 2.0 to 8.0 m down"


def test_bridges_that_were_received_of_are_reported_and_one_that_sends_nothing_is_bad() -> None:
    well = Health(
        "bridge_json", 7, 0, 0, 0, True, [], {"sent_lists": 12, "left_out_obstacles": 1}, {}, {}, {}, 1.0, 9.0
    )
    bad = replace(well, process="bridge_ttm", problems=["nothing is sent: the list is not valid"], counters={})
    received = {each.process: each for each in (bad, well, replace(well, process="tracker"))}
    found = bridges(received, lambda name: 0.1)
    assert [(each.name, each.bad, each.sent, each.left_out) for each in found] == [
        ("json", False, 12, 1), ("ttm", True, 0, 0),
    ]  # fmt: skip
    assert found[1].state == "nothing is sent: the list is not valid"
    assert [each.bad for each in bridges(received, lambda name: 60.0)] == [True, True]
