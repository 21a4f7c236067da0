"""Detections of a real sonar in a harbour, an image each 3.4 s."""

from pathlib import Path

from benchmarks.tracker.harbour import figures, read, tracked, visits_of
from ods.tracker.settings import TrackerSettings

RECORDING = Path(__file__).parent.parent / "data/aracati2017/aracati_detections.npz"


def test_what_recurs_in_a_harbour_is_listed_and_known_again() -> None:
    harbour = read(RECORDING)
    places, visits = visits_of(harbour)
    found = figures(list(tracked(harbour, harbour.true, 0.5, TrackerSettings())), places, visits)
    assert found.listed > 0.45
    assert found.again > 50
    assert found.same > 0.5 * found.again
