"""`ods assess detect`: its images, its table of settings, its measurement, its chart."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from ods import cli
from ods.assess.detection.assessment import QUICK_EFFORT, Effort, measure
from ods.assess.detection.chains import DEFAULT, EQUALIZERS, all_settings
from ods.assess.detection.measure import filter_figures
from ods.assess.images.sea import sea_images, snr_db
from ods.assess.images.tank import TANK_BEAMS, TANK_SAMPLES, tank_images
from ods.messages import frame_of
from ods.pipeline.chain import Chain
from tests.assess.real_frames import REAL

pytestmark = pytest.mark.slow

TINY = Effort(sea=2, tank=2, checked=1, filtered=1, rounds=1, settings=2)


def test_every_setting_can_be_built_and_has_its_own_name() -> None:
    settings = all_settings()
    names = [setting.name for setting in settings]
    assert names[0] == DEFAULT
    assert len(set(names)) == len(names) > 10
    for setting in settings:
        Chain(setting.settings[0])


def test_tank_images_are_the_same_for_the_same_seed_and_labelled_where_they_shine() -> None:
    images, again, other = tank_images(6, 1), tank_images(2, 1), tank_images(1, 2)
    assert images[1].ping == again[1].ping
    assert images[0].ping != other[0].ping
    gain = []
    for image in images:
        counts = frame_of(image.ping).astype(np.float64)
        assert counts.shape == (TANK_BEAMS, TANK_SAMPLES)
        bearing = np.array(image.ping.bearing_rad)
        distance = image.ping.range0_m + image.ping.dr_m * np.arange(TANK_SAMPLES)
        for target in image.targets:
            rows = (bearing >= target.bearing_rad[0]) & (bearing <= target.bearing_rad[1])
            columns = (distance >= target.range_m[0]) & (distance <= target.range_m[1])
            inside = counts[np.ix_(rows, columns)]
            gain.append(float(np.quantile(inside, 0.9)) - float(np.median(counts[rows])))
    assert len(gain) >= 6
    assert np.median(gain) > 20  # counts, of 3.2 a decibel


def test_sea_images_have_truth_of_all_strengths() -> None:
    images = sea_images(3, 1)
    assert images[2].ping == sea_images(3, 1)[2].ping
    targets = [target for image in images for target in image.targets]
    assert len(targets) > 12
    assert any(target.counts for target in targets)
    for target in targets:
        assert target.circle is not None
        assert target.range_m[0] < target.circle[0] < target.range_m[1]
        assert 0.3 <= target.circle[2] <= 6.0


def test_signal_to_noise_ratio_takes_the_noise_out_of_the_peak() -> None:
    assert snr_db(10 * np.log10(2.0), 0.0) == pytest.approx(0.0)
    assert snr_db(10 * np.log10(11.0) + 7.0, 7.0) == pytest.approx(10.0)
    assert snr_db(0.0, 0.0) < -80.0


def test_a_box_suppresses_noise_and_rounds_edges() -> None:
    images = sea_images(1, 3)
    plain, edges = filter_figures(EQUALIZERS, images)
    smooth, rounded = filter_figures([*EQUALIZERS, {"use": "filter.box", "window": 9}], images)
    assert plain == 0.0
    assert 2.0 < smooth < 9.6  # 10 log10(9) for white speckle; this one is not, and gain errors stay
    assert -1.0 <= edges <= 1.0
    assert rounded != edges


def test_measurement_is_deterministic_but_for_time() -> None:
    first, second = measure(TINY), measure(TINY)
    assert [repr(replace(row, ms=0.0)) for row in first] == [repr(replace(row, ms=0.0)) for row in second]
    assert first[0].name == DEFAULT
    assert all(row.ms > 0.0 and 0.0 <= row.sea.detection_probability <= 1.0 for row in first)


def test_command_prints_a_table_and_draws_the_chart(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    chart = tmp_path / "chart.png"
    real = [word for pair in REAL.items() for word in ("--real", *pair)]
    assert cli.main(["assess", "detect", "--quick", "--out", str(chart), *real]) == 0
    text = capsys.readouterr().out
    assert text.count("no filter, ") == QUICK_EFFORT.settings - 1
    assert "default" in text
    assert "sample.aris" in text
    assert "left out" not in text
    assert chart.read_bytes().startswith(b"\x89PNG")


def test_without_real_frames_it_says_what_it_leaves_out(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["assess", "detect", "--quick"]) == 0
    assert "real frames are omitted" in capsys.readouterr().out


def test_a_chart_that_cannot_be_written_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "no"
    assert cli.main(["assess", "detect", "--quick", "--out", str(folder / "chart.png")]) == 2
    assert capsys.readouterr().err == f"ods assess: {folder / 'chart.png'}: no such folder: {folder}\n"
