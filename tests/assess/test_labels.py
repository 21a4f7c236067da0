"""Labels of real frames, and the look-alikes that are kept out of all choices."""

from pathlib import Path

import numpy as np
import pytest

from ods.assess.detection.measure import score_of
from ods.assess.images.held_out import BEAM_COUNTS, held_out_images
from ods.assess.images.labelled import LabelledImage
from ods.assess.images.labels import read_labels
from ods.base.errors import OdsError
from ods.messages import frame_of
from ods.pipeline.settings import PipelineSettings
from ods.sonar_link.files.opening import open_pings
from tests.assess.real_frames import REAL

pytestmark = pytest.mark.slow


def contrasts(images: list[LabelledImage]) -> list[float]:
    """Counts by which the brighter part of each label's box is above the middle of its own ranges."""
    gain = []
    for image in images:
        ping = image.ping
        counts = frame_of(ping).astype(np.float64)
        bearing, distance = np.array(ping.bearing_rad), ping.range0_m + ping.dr_m * np.arange(ping.samples)
        for target in filter(lambda target: target.counts, image.targets):
            rows = (bearing >= target.bearing_rad[0]) & (bearing <= target.bearing_rad[1])
            columns = (distance >= target.range_m[0]) & (distance <= target.range_m[1])
            inside = counts[np.ix_(rows, columns)]
            gain.append(float(np.quantile(inside, 0.9)) - float(np.median(counts[:, columns])))
    return gain


@pytest.mark.parametrize(("recording", "labels"), REAL.items())
def test_labels_of_real_frames_lie_where_something_shines(recording: str, labels: str) -> None:
    images = read_labels(Path(labels), open_pings(Path(recording)).pings)
    assert len(images) == 3
    assert min(contrasts(images)) > 0.0


@pytest.mark.parametrize("line", ["0 1 2 3", "0 1 2 3 x", "9 1 2 3 4", "0 5 4 1 2", "0 1 48 1 2"])
def test_a_label_that_makes_no_sense_is_named(tmp_path: Path, line: str) -> None:
    file = tmp_path / "labels.txt"
    file.write_text(f"# a comment\n{line}\n")
    pings = open_pings(Path("tests/data/aris/sample.aris")).pings
    with pytest.raises(OdsError, match=r"labels\.txt:2"):
        read_labels(file, pings)


def test_a_file_of_labels_that_is_no_text_is_one_line() -> None:
    recording = Path("tests/data/aris/sample.aris")
    with pytest.raises(OdsError, match=r"sample\.aris: no labels: not UTF-8 text"):
        read_labels(recording, open_pings(recording).pings)


def test_held_out_images_differ_in_geometry_and_show_their_labels() -> None:
    images = held_out_images(12, 5)
    assert images[3].ping == held_out_images(4, 5)[3].ping
    assert {image.ping.beams for image in images} == set(BEAM_COUNTS)
    gain = contrasts(images)
    assert len(gain) >= 6
    assert np.median(gain) > 10.0


def test_default_chain_finds_most_of_what_it_was_not_chosen_on() -> None:
    score = score_of(PipelineSettings(), held_out_images(80, 6))
    assert score.detection_probability > 0.85
    assert score.false_per_image < 5.0
