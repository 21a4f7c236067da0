"""`ods missions --chart`: variants at speeds, in one picture and tables, and gone on with where it was stopped."""

import csv
import json
from pathlib import Path
from typing import Literal

import numpy as np
import pytest
from matplotlib.figure import Figure
from msgspec.structs import replace

from ods.cli import main
from ods.missions.chart.picture import chart_figure
from ods.missions.chart.point import Point
from ods.missions.chart.run import at_speed, varied
from ods.missions.detections.laws import Laws, fingerprints
from ods.missions.settings import Campaign, Variant
from ods.missions.setup import onboard_of, sonar_of
from ods.missions.statistics import Paired, rate_of
from tests.missions.test_detections import laws_of

CHART = """
seed = 5
missions = 1
[world]
length_m = 50.0
width_m = 40.0
obstacles_per_hectare = 20.0
[chart]
speeds_m_s = [2.0, 3.0]
image_missions = 1
[[chart.variant]]
name = "built-in"
[[chart.variant]]
name = "range 30 m"
varies = "range"
range_m = 30.0
"""


def known_laws(campaign: Campaign, _: int) -> tuple[None, Laws]:
    sonar, onboard = sonar_of(campaign), onboard_of(campaign)
    return None, replace(laws_of(0.95), **fingerprints(campaign, onboard.pipeline, sonar))


def test_all_variants_are_flown_at_all_speeds_and_not_twice(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("ods.missions.chart.run.fitted", known_laws)
    monkeypatch.setattr("ods.missions.chart.cost.PINGS", 20)
    file, out = tmp_path / "chart.toml", tmp_path / "out"
    file.write_text(CHART)
    command = ["missions", str(file), "--chart", "--out", str(out)]
    assert main(command) == 0
    rows = list(csv.DictReader((out / "chart.csv").read_text().splitlines()))
    assert [(row["name"], row["speed_m_s"], row["fidelity"], row["missions"]) for row in rows] == [
        (name, speed, fidelity, "1")
        for name in ("built-in", "range 30 m")
        for speed in ("2.0", "3.0")
        for fidelity in ("detections", "images")
    ]
    assert float(rows[4]["pings_a_second"]) > 2.5 * float(rows[0]["pings_a_second"])
    assert float(rows[0]["ms"]) > 1.0
    assert (out / "chart.png").stat().st_size > 10_000
    assert json.loads((out / "chart.json").read_text())[0]["collision"]["of"] == 1
    assert "built-in" in capsys.readouterr().out
    journals = {path: path.read_bytes() for path in out.rglob("missions.jsonl")}
    assert len(journals) == 8
    monkeypatch.setattr("ods.missions.chart.run.fitted", None)
    assert main(command) == 0
    assert {path: path.read_bytes() for path in out.rglob("missions.jsonl")} == journals


def test_a_variant_and_a_speed_change_what_they_name_and_nothing_else() -> None:
    campaign = Campaign(seed=1)
    assert varied(campaign, Variant(name="same")) == campaign
    assert varied(campaign, Variant(name="near", range_m=30.0)) == replace(campaign, range_m=30.0)
    fast, slow = at_speed(campaign, 4.0), at_speed(campaign, 0.5)
    assert (fast.planner.cruise_m_s, fast.planner.slow_m_s, fast.vehicle.most_m_s) == (4.0, 1.0, 4.0)
    assert slow.planner.cruise_m_s == 0.5 > slow.planner.slow_m_s >= slow.vehicle.least_m_s
    assert replace(fast, planner=campaign.planner, vehicle=campaign.vehicle) == campaign


def point(name: str, speed: float, collisions: int, fidelity: Literal["detections", "images"] = "detections") -> Point:
    return Point(name=name, varies="range" if "range" in name else "", speed_m_s=speed, ms=3.0, pings_a_second=6.7,
                 fidelity=fidelity, collision=rate_of(collisions, 50), success=rate_of(50 - collisions, 50),
                 first_listed_m=None, against_first=Paired("built-in", name, 0, 0, 1.0),
                 evasions_of_nothing=0.0)  # fmt: skip


def test_the_picture_has_a_panel_a_speed_and_each_point_at_its_place() -> None:
    figure = chart_figure([point(name, speed, 5) for name in ("built-in", "range 30 m") for speed in (1.0, 2.0)])
    assert isinstance(figure, Figure)
    assert ["1 m/s" in axes.get_title() or "2 m/s" in axes.get_title() for axes in figure.axes] == [True, True]
    for axes in figure.axes:
        points = [np.array([line.get_xdata(), line.get_ydata()]) for line in axes.lines if line.get_marker() == "o"]
        assert np.ravel(points).tolist() == [3.0, 10.0] * 2


def test_points_by_images_are_hollow() -> None:
    figure = chart_figure([point("built-in", 1.0, 5), point("built-in", 1.0, 9, "images")])
    faces = [line.get_markerfacecolor() for line in figure.axes[0].lines if line.get_marker() == "o"]
    assert [face == "none" for face in faces] == [False, True]


def test_mistakes_are_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "chart.toml"
    file.write_text(CHART.replace('"range 30 m"', '"built-in"'))
    assert main(["missions", str(file), "--chart", "--out", str(tmp_path / "out")]) == 2
    assert "chart" in (line := capsys.readouterr().err)
    assert "two have the same name" in line
    assert main(["missions", str(file), "--chart", "--fit", str(tmp_path / "laws.json")]) == 2
    assert "--chart: needs --out" in capsys.readouterr().err
