"""`ods missions`: same bytes however it is run, and mistakes in one line."""

import csv
import json
from pathlib import Path

import pytest

from ods.base.files.shipped import shipped_file
from ods.cli import main
from tests.missions.campaigns import results

CAMPAIGN = """
seed = 3
missions = 3
arms = ["none", "truth"]
[world]
length_m = 60.0
width_m = 40.0
obstacles_per_hectare = 40.0
"""


def test_results_are_reported_and_kept(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    _, table, summary = results(campaign, "out")
    reported = capsys.readouterr().out
    rows = list(csv.DictReader(table.decode().splitlines()))
    assert [(row["mission"], row["arm"]) for row in rows] == [
        (str(k), arm) for k in range(3) for arm in ("none", "truth")
    ]
    none, truth = json.loads(summary)["arms"]
    assert none["collision"]["count"] == sum(row["arm"] == "none" and row["ending"] == "collision" for row in rows) > 0
    assert truth["collision"]["count"] == 0
    assert "McNemar" in reported
    assert f"{none['collision']['count']} of 3" in " ".join(reported.split())


@pytest.mark.slow
def test_two_processes_make_the_same_bytes(campaign: Path) -> None:
    campaign.write_text(CAMPAIGN.replace('"truth"', '"ods", "truth"').replace("60.0", "50.0"))
    assert results(campaign, "one") == results(campaign, "two", "--workers", "2")


def test_a_stopped_campaign_goes_on_to_the_same_bytes(campaign: Path) -> None:
    whole = results(campaign, "out")
    journal = campaign.parent / "out" / "missions.jsonl"
    for cut in (-1, -30, -400, 20):
        journal.write_bytes(whole[0][:cut])
        assert results(campaign, "out") == whole, cut


def test_what_is_done_is_not_flown_again(campaign: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = results(campaign, "out")
    monkeypatch.setattr("ods.missions.run.fly", None)
    assert results(campaign, "out") == whole


def refusal(campaign: Path, capsys: pytest.CaptureFixture[str]) -> str:
    assert main(["missions", str(campaign), "--out", str(campaign.parent / "out")]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    return line


def test_results_of_another_campaign_are_not_mixed(campaign: Path, capsys: pytest.CaptureFixture[str]) -> None:
    results(campaign, "out")
    campaign.write_text(CAMPAIGN.replace("seed = 3", "seed = 4"))
    assert "missions.jsonl: belongs to another campaign" in refusal(campaign, capsys)


def test_results_by_other_settings_or_another_sonar_of_the_same_name_are_not_mixed(
    campaign: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = campaign.parent
    onboard, sonar = folder / "onboard.toml", folder / "sonar.toml"
    config = shipped_file("onboard.toml").read_text()
    onboard.write_text(config)
    seabat = shipped_file("sonars/seabat6012.toml").read_text()
    sonar.write_text(seabat)
    campaign.write_text(f'onboard = "{onboard}"\nsonar = "{sonar}"\n{CAMPAIGN}')
    whole = results(campaign, "out")
    assert results(campaign, "out") == whole
    sonar.write_text(seabat.replace("overhead_s = 0.016", "overhead_s = 0.1"))
    assert "missions.jsonl: belongs to another campaign" in refusal(campaign, capsys)
    sonar.write_text(seabat)
    onboard.write_text(config.replace("[tracker.map]", "[tracker.life]\nconfirm_echoes = 4\n\n[tracker.map]"))
    assert "missions.jsonl: belongs to another campaign" in refusal(campaign, capsys)


@pytest.mark.parametrize("line", ["nonsense", '{"mission": 0}', '{"mission": "x"}'])
def test_a_journal_that_is_none_is_refused(campaign: Path, line: str, capsys: pytest.CaptureFixture[str]) -> None:
    results(campaign, "out")
    journal = campaign.parent / "out" / "missions.jsonl"
    head = journal.read_bytes().splitlines(keepends=True)[0]
    journal.write_bytes(head + line.encode() + b"\n")
    assert "missions.jsonl" in refusal(campaign, capsys)


@pytest.mark.parametrize(
    ("text", "reported"),
    [
        ("seed = -1", "seed"),
        ('seed = 1\narms = ["odss"]', "arms"),
        ('seed = 1\narms = ["ods", "ods"]', "arms"),
        ("seed = 1\nmissions = 0", "missions"),
        ('seed = 1\nsonar = "seabatt6012"', "sonar"),
        ("seed = 1\n[world]\nradius_m = [3.0, 1.0]", "world.*radius_m"),
        ("seed = 1\n[world]\nlength_m = 4000.0\nwidth_m = 4000.0", "obstacles_per_hectare"),
        ("seed = 1\n[world]\nsea_bed = { depth_m = 10.0 }", "sea_bed.depth_m"),
        ("seed = 1\n[planner]\nclimb_to_m = 50.0", "planner.climb_to_m"),
        ("seed = 1\n[planner]\nkeep = 3.0", "planner.keep"),
        ('seed = 1\nonboard = "nowhere.toml"', "nowhere.toml"),
    ],
)
def test_mistakes_are_one_line_that_names_the_key(
    campaign: Path, text: str, reported: str, capsys: pytest.CaptureFixture[str]
) -> None:
    campaign.write_text(text)
    line = refusal(campaign, capsys)
    assert line.startswith("ods missions: ")
    assert all(part in line for part in reported.split(".*"))
