"""Detections drawn by laws: geometry against brute force, laws against what they were made of, both fidelities."""

import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from msgspec.structs import astuple, replace

from ods.base.errors import OdsError
from ods.cli import main
from ods.messages import Detection, Sector
from ods.missions.detections.agreement import compared
from ods.missions.detections.draw import Drawing, Placed, echoes_of
from ods.missions.detections.fit import fitted, round_of
from ods.missions.detections.fitting import Received, clutter_law, echo_law, errors_of, logit_of, matched
from ods.missions.detections.laws import Errors, Laws, load_laws, save_laws, sonar_fingerprint
from ods.missions.detections.sights import WORDS, Fan, Sights, fan_of, seen_of
from ods.missions.parallel.fly import fly, tasks_of
from ods.missions.parallel.workers import Task
from ods.missions.settings import Campaign, WorldSettings
from ods.sim_sonar.by_name import find_sonar

WORLD = WorldSettings(
    length_m=80.0, width_m=60.0, obstacles_per_hectare=40.0, moving_share=0.5, radius_m=(0.4, 1.5),
    speed_m_s=(0.3, 1.5), free_start_m=15.0, free_goal_m=10.0,
)  # fmt: skip


def fan() -> Fan:
    return fan_of(find_sonar("seabat6012"))


def sights(*bodies: tuple[float, float, float]) -> Sights:
    """Return what is seen of circles (distance, bearing in degrees, radius)."""
    distance, bearing, radius = np.array(bodies, np.float64).reshape(-1, 3).T
    return seen_of(distance, np.radians(bearing), radius, fan())


def test_a_body_alone_is_seen_by_its_front_and_whole() -> None:
    seen = sights((30.0, 10.2, 2.0))
    assert seen.near_m[0] == pytest.approx(28.0, abs=0.02)
    assert seen.bearing[0] == pytest.approx(math.radians(10.2))
    assert seen.width[0] == pytest.approx(2.0 * math.asin(2.0 / 30.0), abs=0.014)
    assert (seen.shown[0] > 0.95, bool(seen.at_edge[0]), bool(seen.at_end[0])) == (True, False, False)


def test_what_stands_behind_is_hidden_as_far_as_it_does() -> None:
    """The nearer one covers -3.8 to 3.8 degrees; of the farther one, -0.7 to 5.1 degrees, 1.3 of 5.7 are left."""
    seen = sights((30.0, 0.0, 2.0), (60.0, 2.2, 3.0), (50.0, 0.0, 1.0))
    assert seen.body.tolist() == [0, 1]
    assert seen.shown[1] == pytest.approx(1.3 / 5.7, abs=0.1)
    assert seen.bearing[1] == pytest.approx(math.radians(4.45), abs=0.007)


def test_outside_of_the_fan_and_beyond_the_range_nothing_is_seen_and_borders_are_reported() -> None:
    seen = sights((30.0, 60.0, 2.0), (130.0, 0.0, 2.0), (30.0, -44.0, 2.0), (101.0, 10.0, 2.0))
    assert seen.body.tolist() == [2, 3]
    assert seen.at_edge.tolist() == [True, False]
    assert seen.at_end.tolist() == [False, True]


def echo(near_m: float, bearing: float) -> Detection:
    values: dict[str, Any] = {"range_m": near_m + 1.1, "bearing_rad": bearing, "radius_m": 1.2, "peak": 20.0,
              "mean": 7.0,
              "snr_db": 26.0, "cells": 1, "range_extent_m": 1.5, "bearing_extent_rad": 0.1, "sigma_range_m": 0.2,
              "sigma_bearing_rad": 0.004, "sigma_radius_m": 0.3, "near_m": near_m, "sigma_near_m": 0.1, "onset": 1.3,
              "front": 0.98}  # fmt: skip
    return Detection(**values)


def test_errors_of_an_echo_make_the_echo_again() -> None:
    body = sights((30.0, 10.0, 1.0))
    received = echo(29.1, 0.18)
    found = errors_of(received, float(body.near_m[0]), 1.0, float(body.bearing[0]), fan())
    (again,) = echoes_of(Errors(*found[:, None]), body, np.zeros(1, bool), fan())
    reported = dict(zip(Detection.__struct_fields__, zip(astuple(received), astuple(again), strict=True), strict=True))
    for name, (one, other) in reported.items():
        if name not in ("peak", "mean"):
            assert other == pytest.approx(one, rel=1e-6), name
    assert again.mean / again.peak == pytest.approx(7.0 / 20.0)


def test_each_body_has_one_echo_at_most_and_the_nearest() -> None:
    bodies = sights((30.0, 0.0, 1.0), (60.0, 10.0, 1.0))
    echoes = [echo(29.6, 0.0), echo(29.1, 0.01), echo(50.0, 0.17)]
    assert matched(bodies, echoes, fan()) == [1, None]


def test_a_probability_is_found_again() -> None:
    rng = np.random.default_rng(1)
    features = np.column_stack([np.ones(20000), rng.random(20000)])
    happened = rng.random(20000) < 1.0 / (1.0 + np.exp(-(3.0 - 4.0 * features[:, 1])))
    found = 1.0 / (1.0 + np.exp(-features[:300] @ logit_of(features, happened)))
    assert found == pytest.approx(1.0 / (1.0 + np.exp(-(3.0 - 4.0 * features[:300, 1]))), abs=0.05)


def test_what_comes_again_and_again_is_found() -> None:
    near, far = [(0.0, 30.0)], [(0.0, 50.0)]
    assert round_of([near, far, far] * 5) == [near, far, far]
    assert round_of([near] * 5) == [near]
    assert round_of([[]] * 5) == [[]]


def laws_of(seen: float, clutter: int = 0) -> Laws:
    """Return laws of echoes with errors that are known: bias 0.1 m of the front, 0.2 beams of bearing, memory 0.8."""
    rng = np.random.default_rng(2)
    bodies, pings = 20, 300
    count, size = bodies * pings, len(Errors._fields)
    scores = rng.standard_normal((pings, bodies, size))
    for ping in range(1, pings):
        scores[ping] = 0.8 * scores[ping - 1] + 0.6 * scores[ping]
    errors = 0.2 * scores.reshape(count, size)
    errors[:, 0] += 0.1
    errors[:, 11] += 25.0
    features = np.zeros((count, len(WORDS)))
    features[:, 0] = 1.0
    yes = np.ones(count, bool)
    received = Received(np.zeros(count, int), np.repeat(np.arange(pings), bodies), np.tile(np.arange(bodies), pings),
                  features, yes, ~yes, ~yes, errors)  # fmt: skip
    law = echo_law(received, yes)
    alone = [echo(20.0 + k, 0.1) for k in range(clutter)]
    none = (-15.0, *[0.0] * (len(WORDS) - 1))
    clear = clutter_law([], 1)
    noise = replace(clear, per_scan=2.0, stays=0.5, echoes=alone, faint=[False] * clutter)
    return Laws(
        sonar="", pipeline="", world="", features=list(WORDS), lowest=tuple([0.0] * len(WORDS)),
        highest=tuple([1.0] * len(WORDS)), seen=(math.log(seen / (1.0 - seen)), *[0.0] * (len(WORDS) - 1)),
        faint=none, cut=none, errors=list(Errors._fields), whole=law, cut_off=law, clutter=noise,
        sector=Sector(0.1, 100.0, -0.78, 0.78, 0.17), processed_ranges_m=[[]], heard_from_db=8.0, chain_ms=1.0,
        pings=pings, echoes=count,
    )  # fmt: skip


def test_what_is_drawn_has_the_errors_the_probability_and_the_memory_of_its_laws() -> None:
    drawing = Drawing(laws_of(0.8), 1, fan(), np.random.default_rng(3))
    bodies = sights((30.0, 0.0, 1.0))
    drawn = [drawing.detections(k, k, k, bodies, Placed(0.0, 0.0, 0.0)).detections for k in range(6000)]
    off = np.array([each[0].near_m - bodies.near_m[0] if each else math.nan for each in drawn])
    assert np.mean(~np.isnan(off)) == pytest.approx(0.8, abs=0.03)
    assert np.nanmean(off) == pytest.approx(0.1, abs=0.04)
    assert np.nanstd(off) == pytest.approx(0.2, rel=0.15)
    both = ~np.isnan(off[1:]) & ~np.isnan(off[:-1])
    assert np.corrcoef(off[:-1][both], off[1:][both])[0, 1] == pytest.approx(0.8, abs=0.08)


def test_clutter_comes_as_often_as_it_did_and_stays_where_it_is() -> None:
    """The head goes north by 0.1 m a ping: what stays comes nearer by that."""
    drawing = Drawing(laws_of(0.8, clutter=30), 0, fan(), np.random.default_rng(4))
    none, before, counts, stayed = sights(), np.array([]), [], 0
    for ping in range(3000):
        head = Placed(0.1 * ping, 0.0, 0.0)
        received = drawing.detections(ping, ping, ping, none, head).detections
        north = np.array([head.north_m + each.range_m * math.cos(each.bearing_rad) for each in received])
        stayed += sum(bool(np.any(np.abs(north - one) < 1e-6)) for one in before)
        counts.append(len(received))
        before = north
    assert np.mean(counts) == pytest.approx(2.0, rel=0.1)
    assert stayed / sum(counts) == pytest.approx(0.5, abs=0.05)


def test_what_is_not_processed_is_not_received() -> None:
    near_only = replace(laws_of(0.99), processed_ranges_m=[[(0.0, 20.0)], [(0.0, 100.0)]])
    drawing = Drawing(near_only, 1, fan(), np.random.default_rng(5))
    found = [drawing.detections(k, k, k, sights((30.0, 0.0, 1.0)), Placed(0.0, 0.0, 0.0)) for k in range(40)]
    assert not any(each.detections for each in found[::2])
    assert sum(bool(each.detections) for each in found[1::2]) > 15
    assert found[0].processed_ranges_m == [(0.0, 20.0)]


def test_laws_of_something_else_or_of_another_version_are_refused_in_a_line(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file, campaign = tmp_path / "laws.json", tmp_path / "campaign.toml"
    save_laws(laws_of(0.8, clutter=3), file)
    assert load_laws(file) == laws_of(0.8, clutter=3)
    campaign.write_text('seed = 1\nfidelity = "detections"\ndetections = "laws.json"\n')
    command = ["missions", str(campaign), "--out", str(tmp_path / "out")]
    assert main(command) == 2
    assert "detections: " in (line := capsys.readouterr().err)
    assert "another sonar" in line
    file.write_text(file.read_text().replace('"hidden"', '"concealed"'))
    load_laws.cache_clear()
    assert main(command) == 2
    assert "fit it again" in capsys.readouterr().err
    campaign.write_text('seed = 1\nfidelity = "detections"\n')
    assert main(command) == 2
    assert "detections: " in capsys.readouterr().err


def test_a_sonar_has_one_fingerprint_in_all_processes() -> None:
    """By it a stopped campaign goes on."""
    code = (
        "from ods.sim_sonar.by_name import find_sonar; from ods.missions.detections.laws import sonar_fingerprint; "
        "print(sonar_fingerprint(find_sonar('seabat6012')), end='')"
    )
    reported = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, text=True).stdout
    assert reported == sonar_fingerprint(find_sonar("seabat6012")) != sonar_fingerprint(find_sonar("sonar3d15"))


def test_a_sonar_of_several_planes_is_refused() -> None:
    with pytest.raises(OdsError, match=r"sonar: .*sees in 3-D"):
        fitted(Campaign(seed=1, sonar="seabat6012_3plane"), 1)


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_both_fidelities_agree_within_their_intervals(tmp_path: Path) -> None:
    """As `python -m benchmarks.missions.fidelities` shows it; the same again is the same."""
    campaign = Campaign(seed=43, missions=14, arms=("ods",), world=WORLD)
    save_laws(fitted(campaign, 4)[1], tmp_path / "laws.json")
    drawn = replace(campaign, fidelity="detections", detections=tmp_path / "laws.json")
    images, detections = ([fly(task).outcome for task in tasks_of(each)] for each in (campaign, drawn))
    rows = {row.name: row for row in compared(images, detections)}
    for name in ("success, %", "collision, %", "first listed at, m"):
        assert rows[name].agree, rows[name]
    assert fly(Task(drawn, 3, "ods")).outcome == detections[3]
