"""What the Foxglove file's log says; the rest of it is read by node (test_by_node.py)."""

import msgspec

from ods.base.geodesy import LocalFrame
from ods.export.foxglove_file import FoxgloveMessages
from tests.export import mission
from tests.export.mission import UTC_NS


def lines_of(*problems: str) -> int:
    """Return how many lines of the log a process makes that says these one after the other; "": nothing is wrong."""
    messages = FoxgloveMessages(mission.MOUNTED, LocalFrame(57.0, 10.0))
    reported = [msgspec.structs.replace(mission.HEALTH, problems=[text] if text else []) for text in problems]
    return sum(len(messages.of(UTC_NS, health)) for health in reported)


def test_the_log_has_a_line_where_something_is_new() -> None:
    assert lines_of("", "") == 0
    assert lines_of("no ping for 1.5 s", "no ping for 2.0 s", "no ping for 12 s") == 1
    assert lines_of("no ping for 1.5 s", "no pose for 1.5 s", "", "no ping for 1.5 s") == 4
