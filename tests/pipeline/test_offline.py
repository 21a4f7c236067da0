import json
from pathlib import Path

import numpy as np
import pytest

from ods.messages import Ping
from ods.pipeline.offline import detect_pings, json_line, save_npz
from ods.pipeline.settings import PipelineSettings
from tests.pipeline.pings import make_ping


def ping(column: int, samples: int = 500) -> Ping:
    frame = np.random.default_rng(column).rayleigh(20.0, (32, samples))
    frame[12:16, column : column + 20] += 300.0
    return make_ping(frame.astype(np.uint16))


BAD = make_ping(np.ones((32, 500), np.uint16), dr_m=-1.0)


def test_file_has_the_documented_layout(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    results = list(detect_pings([ping(100), BAD, ping(300)], PipelineSettings(), masks=True))
    assert "skipped ping 1 of the file: dr_m" in caplog.text
    assert [result.place for result in results] == [0, 2]
    file = tmp_path / "det.out"  # whatever its name ends in
    save_npz(file, results)
    with np.load(file) as saved:
        det, mask = saved["det"], saved["mask"]
    assert det.shape[1] == 8
    assert mask.shape == (3, 32, 500)
    assert mask.dtype == np.int32
    assert not mask[1].any()
    for place, column in ((0, 100), (2, 300)):
        rows = det[det[:, 0] == place]
        assert len(rows) == len(results[place // 2].detections.detections) == mask[place].max()
        best = rows[rows[:, 7].argmax()]
        number = int(rows[:, 7].argmax()) + 1
        assert 2 * best[7] == (mask[place] == number).sum()  # cells of two samples each
        assert best[1] == pytest.approx((column + 10) * 0.05, abs=1.0)
        detection = results[place // 2].detections.detections[number - 1]
        assert best[1:7].tolist() == [
            detection.range_m,
            detection.bearing_rad,
            detection.radius_m,
            detection.peak,
            detection.mean,
            detection.snr_db,
        ]


def test_no_pings_give_an_empty_table(tmp_path: Path) -> None:
    save_npz(tmp_path / "det.npz", [])
    with np.load(tmp_path / "det.npz") as saved:
        assert saved["det"].shape == (0, 8)
        assert "mask" not in saved


def test_masks_of_unlike_pings_are_refused(tmp_path: Path) -> None:
    results = list(detect_pings([ping(100), ping(100, samples=400)], PipelineSettings(), masks=True))
    with pytest.raises(ValueError, match="mask: the pings differ in shape"):
        save_npz(tmp_path / "det.npz", results)


def test_json_is_one_line_a_ping() -> None:
    (result,) = detect_pings([ping(100)], PipelineSettings())
    line = json_line(result)
    assert "\n" not in line
    decoded = json.loads(line)
    assert decoded["index"] == 0
    assert decoded["ping_number"] == 77
    assert len(decoded["detections"]) == len(result.detections.detections)
    assert decoded["detections"][0]["range_m"] == result.detections.detections[0].range_m
