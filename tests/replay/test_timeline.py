import msgspec
import pytest

from ods.messages import ObstacleList
from ods.replay.timeline import Timeline, moved
from tests.export import mission
from tests.export.mission import T_NS, UTC_NS

OFFSET_NS = UTC_NS - T_NS
"""Of the recording."""
NOW_NS, NOW_UTC_NS = 77_000_000_123, 1_800_000_000_000_000_000


def line_at(speed: float) -> Timeline:
    line = Timeline(speed, NOW_UTC_NS - NOW_NS)
    line.begin(T_NS, NOW_NS)
    return line


def test_all_times_move_by_one_offset() -> None:
    line = line_at(1.0)
    for message in mission.ALL:
        now = moved(message, line, OFFSET_NS)
        for name in message.__struct_fields__:
            before, after = getattr(message, name), getattr(now, name)
            if name.endswith("utc_ns") and before:
                assert after - before == NOW_UTC_NS - UTC_NS
            elif name.endswith("_ns") and before:
                assert after - before == NOW_NS - T_NS
            elif name != "obstacles":
                assert after == before
    picture = moved(mission.LIST, line, OFFSET_NS)
    assert isinstance(picture, ObstacleList)
    (rock,) = picture.obstacles
    assert rock.last_seen_utc_ns - rock.first_seen_utc_ns == 9
    assert rock.last_seen_utc_ns == NOW_UTC_NS


def test_what_was_not_reported_stays_so() -> None:
    silent = msgspec.structs.replace(mission.LIST, t_rx_ns=0, made_ns=0)
    now = moved(silent, line_at(1.0), OFFSET_NS)
    assert [getattr(now, name) for name in ("t_rx_ns", "made_ns")] == [0, 0]


@pytest.mark.parametrize(("speed", "after_ns"), [(2.0, 1_500_000_000), (0.5, 6_000_000_000), (1.0, 3_000_000_000)])
def test_at_another_speed_time_is_stretched(speed: float, after_ns: int) -> None:
    line = line_at(speed)
    assert line.at(T_NS + 3_000_000_000) == NOW_NS + after_ns
    assert line.utc(UTC_NS + 3_000_000_000, OFFSET_NS) == NOW_UTC_NS + after_ns
