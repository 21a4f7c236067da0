"""Labels: written as `ods assess detect` reads them, counted as it counts, and undone as all else."""

from pathlib import Path

import msgspec
import pytest

from ods.assess.detection.metrics import Score
from ods.assess.images.labels import Box, read_labels, target_of
from ods.base.errors import OdsError
from ods.messages import Detection, Detections
from ods.sonar_link.files.opening import open_pings
from ods.workbench.engine.ping import labels
from ods.workbench.model import actions as do
from ods.workbench.model.history import History
from ods.workbench.model.paths import PathError
from ods.workbench.model.state import DataReference, Label, State
from tests.export import mission
from tests.workbench.serving import PROJECT

RECORDING = PROJECT / "tests" / "data" / "aris" / "sample.aris"
STATE = State(
    data=DataReference("file", str(RECORDING)),
    labels=(
        Label(0, (8, 27), (1220, 1395), "ellipse", "bright slanting line"),
        Label(0, (9, 27), (1380, 1515)),
        Label(3, (0, 7), (1355, 1410), text="two lines"),
    ),
)


def test_what_is_written_is_read_by_assess_and_again(tmp_path: Path) -> None:
    file = tmp_path / "labels.txt"
    labels.write(file, STATE)
    images = read_labels(file, open_pings(RECORDING).pings)
    assert [(image.ping.ping_number, len(image.targets)) for image in images] == [
        (open_pings(RECORDING).pings[place].ping_number, count) for place, count in ((0, 2), (3, 1))
    ]
    again = labels.read(file, STATE, [tmp_path, RECORDING.parent])
    assert again == tuple(msgspec.structs.replace(each, shape="rectangle") for each in STATE.labels)
    with pytest.raises(OdsError, match="not under the workbench's folders"):
        labels.read(file, STATE, [RECORDING.parent])


def found_at(*centres: tuple[float, float]) -> Detections:
    """Return detections at ranges and bearings."""
    found = [Detection(r, b, 0.2, 9.0, 4.0, 12.0, 20, 1.0, 0.05, 0.1, 0.01, 0.2) for r, b in centres]
    return msgspec.structs.replace(mission.DETECTIONS, detections=found, processed_ranges_m=[])


def test_detections_are_counted_as_assess_counts_them() -> None:
    """Two in one label, one beside all, and one in the part that two labels share."""
    ping = open_pings(RECORDING).pings[0]
    of_ping = [label for _, label in labels.of_ping(STATE.labels, 0, ping)]

    def at(beam: int, sample: int) -> tuple[float, float]:
        return ping.range0_m + ping.dr_m * sample, ping.bearing_rad[beam]

    for spots in ([], [at(10, 1230), at(10, 1240), at(40, 100)], [at(10, 1385)], [at(26, 1500), at(10, 1385)]):
        detections = found_at(*spots)
        circles, judged = labels.judged_by(detections, of_ping, ping)
        score = Score()
        targets = [target_of(ping, Box(0, *each.beams, *each.samples, "")) for each in of_ping]
        score.count_image(detections.detections, targets)
        assert (len(judged.right), len(judged.false)) == (score.found, score.false_alarms)
        assert len(judged.missed) == score.targets - score.found
        reported = {*judged.more, *judged.false, *(one for one, _ in judged.right)}
        assert reported == set(range(len(spots)))
        assert [circle.name for circle in circles] == ["bright slanting line", "label"]


def test_labels_that_do_not_fit_the_ping_are_passed_over() -> None:
    ping = open_pings(RECORDING).pings[0]
    others = (Label(0, (0, 48), (0, 1)), Label(0, (0, 1), (0, ping.samples)), Label(0, (47, 47), (0, ping.samples - 1)))
    assert [at for at, _ in labels.of_ping(others, 0, ping)] == [2]


def test_drawing_and_taking_away_are_steps() -> None:
    history = History.of(State())
    for label in reversed(STATE.labels):
        history = history.after(do.AddLabel(label))
    assert [each.ping for each in history.state.labels] == [0, 0, 3]
    assert history.undoes == "label bright slanting line in ping 0"
    history = history.after(do.RemoveLabel(2))
    assert [each.ping for each in history.state.labels] == [0, 0]
    assert [each.ping for each in history.undone().state.labels] == [0, 0, 3]
    with pytest.raises(PathError, match="no such label"):
        history.after(do.RemoveLabel(2))


def test_labels_come_back_from_json_or_are_refused() -> None:
    step = do.AddLabel(STATE.labels[0])
    assert msgspec.json.decode(msgspec.json.encode(step), type=do.Step) == step
    for bad in ({"beams": (5, 4)}, {"samples": (2, 1)}, {"text": "a # b"}, {"text": "a\nb"}, {"text": "x" * 81}):
        tables = {"ping": 0, "beams": (1, 2), "samples": (1, 2)} | bad
        with pytest.raises(msgspec.ValidationError):
            msgspec.convert(tables, Label)


def test_there_are_not_too_many() -> None:
    with pytest.raises(PathError):
        History.of(State()).after(do.SetLabels(STATE.labels * 2000, "many"))
