"""Fits, flies and draws all variants of a campaign at all speeds."""

import csv
from collections.abc import Iterator
from contextlib import closing
from io import StringIO
from pathlib import Path
from statistics import median

import msgspec
from msgspec.structs import replace
from rich.console import Console
from rich.table import Table

from ods.base.errors import OdsError, reason_of
from ods.base.files.out_file import written_whole
from ods.missions.chart.cost import ms_a_ping
from ods.missions.chart.picture import chart_figure
from ods.missions.chart.point import Point
from ods.missions.detections.fit import fitted
from ods.missions.detections.laws import save_laws
from ods.missions.journal import Journal, file_name
from ods.missions.outcome import Outcome
from ods.missions.parallel.fly import depends_on, fly, tasks_of
from ods.missions.parallel.workers import flown_of
from ods.missions.settings import Campaign, ChartSettings, Variant
from ods.missions.setup import sonar_of
from ods.missions.statistics import compared, rate_of
from ods.plots.chart import save_figure
from ods.plots.style import drawn_in

MOST_SHARE = 0.9
"""Of its cruise speed, the least speed of a slow vehicle."""


def draw_campaign(campaign: Campaign, out: Path, workers: int, style: str, console: Console) -> None:
    """Leave chart.png, chart.csv and chart.json. What is flown already is not flown again. Raises OdsError."""
    points = []
    for point in points_of(campaign, out, workers):
        points.append(point)
        console.print(f"{point.varies} {point.name}, {point.speed_m_s:g} m/s, by {point.fidelity}: "
                      f"{point.collision.count} of {point.collision.of} collide, {point.ms:.2f} ms a ping",
                      soft_wrap=True)  # fmt: skip
    try:
        write(points, out)
    except OSError as error:
        raise OdsError(f"{out}: {reason_of(error)}") from error
    with drawn_in(style):
        save_figure(chart_figure(points), out / "chart.png")
    console.print(table_of(points))


def points_of(campaign: Campaign, out: Path, workers: int) -> Iterator[Point]:
    """Yield what came of each variant at each speed and fidelity. Raises OdsError."""
    of_first: dict[tuple[float, str], list[Outcome]] = {}
    first_name = campaign.chart.variant[0].name
    for variant in campaign.chart.variant:
        own = varied(campaign, variant)
        folder = out / file_name(variant.name)
        laws_file = folder / "laws.json"
        if not laws_file.exists():
            folder.mkdir(parents=True, exist_ok=True)
            save_laws(fitted(own, campaign.chart.fit_missions)[1], laws_file)
        ms, pings_a_second = ms_a_ping(own), round(1.0 / sonar_of(own).ping_period_s, 2)
        for speed in campaign.chart.speeds_m_s:
            for place, flying in _fidelities(at_speed(own, speed), laws_file, folder / f"{speed:g}"):
                flown = _flown(flying, place, workers)
                first = of_first.setdefault((speed, flying.fidelity), flown)
                listed = [each.first_listed_m for each in flown if each.first_listed_m is not None]
                yield Point(
                    name=variant.name,
                    varies=variant.varies,
                    speed_m_s=speed,
                    fidelity=flying.fidelity,
                    ms=ms,
                    pings_a_second=pings_a_second,
                    collision=rate_of(sum(each.ending == "collision" for each in flown), len(flown)),
                    against_first=compared(first_name, first, variant.name, flown),
                    success=rate_of(sum(each.ending == "success" for each in flown), len(flown)),
                    first_listed_m=round(median(listed), 2) if listed else None,
                    evasions_of_nothing=sum(each.evasions_of_nothing for each in flown) / len(flown),
                )


def _fidelities(campaign: Campaign, laws_file: Path, folder: Path) -> Iterator[tuple[Path, Campaign]]:
    """Yield a campaign by detections, and if the chart wants it one by images, with the folder of its results."""
    by_images = replace(campaign, missions=campaign.chart.image_missions, arms=("ods",), chart=ChartSettings())
    yield folder, replace(by_images, missions=campaign.missions, fidelity="detections", detections=laws_file)
    if campaign.chart.image_missions:
        yield folder.with_name(f"{folder.name} by images"), by_images


def varied(campaign: Campaign, variant: Variant) -> Campaign:
    """Return the campaign with a variant's settings."""
    own = {key: getattr(variant, key) for key in ("range_m", "pipeline", "tracker")}
    return replace(campaign, **{key: value for key, value in own.items() if value is not None})


def at_speed(campaign: Campaign, speed_m_s: float) -> Campaign:
    """Return the campaign with a vehicle that cruises so fast."""
    slow = min(campaign.planner.slow_m_s, MOST_SHARE * speed_m_s)
    vehicle = replace(campaign.vehicle, least_m_s=min(campaign.vehicle.least_m_s, slow),
                      most_m_s=max(campaign.vehicle.most_m_s, speed_m_s))  # fmt: skip
    return replace(campaign, planner=replace(campaign.planner, cruise_m_s=speed_m_s, slow_m_s=slow), vehicle=vehicle)


def _flown(campaign: Campaign, folder: Path, workers: int) -> list[Outcome]:
    """Return all outcomes."""
    with closing(Journal(folder, depends_on(campaign))) as journal:
        for flown in flown_of(tasks_of(campaign)[len(journal.done) :], fly, workers):
            journal.add(flown.outcome)
        return journal.done


def write(points: list[Point], out: Path) -> None:
    """Write chart.json and chart.csv. Raises OSError."""
    with written_whole(out / "chart.json") as part:
        part.write_bytes(msgspec.json.format(msgspec.json.encode(points), indent=2) + b"\n")
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["varies", "name", "fidelity", "speed_m_s", "ms", "pings_a_second", "missions", "collisions", "low",
                     "high", "only_first_collides", "only_this_collides", "p", "first_listed_m",
                     "evasions_of_nothing"])  # fmt: skip
    for each in points:
        rate, pair = each.collision, each.against_first
        writer.writerow([each.varies, each.name, each.fidelity, each.speed_m_s, each.ms, each.pings_a_second, rate.of,
                         rate.count, round(rate.low, 4), round(rate.high, 4), pair.only_first_collides,
                         pair.only_second_collides, round(pair.p, 4), each.first_listed_m,
                         round(each.evasions_of_nothing, 3)])  # fmt: skip
    with written_whole(out / "chart.csv") as part:
        part.write_text(text.getvalue(), encoding="utf-8")


def table_of(points: list[Point]) -> Table:
    """Return one row a variant and fidelity, and one column a speed."""
    speeds = list(dict.fromkeys(each.speed_m_s for each in points))
    table = Table("", "ms a ping", *(f"collisions of 100, {speed:g} m/s" for speed in speeds))
    for name, fidelity in dict.fromkeys((each.name, each.fidelity) for each in points):
        own = [each for each in points if (each.name, each.fidelity) == (name, fidelity)]
        cells = [f"{100 * r.share:.0f} ({100 * r.low:.0f} to {100 * r.high:.0f})" for r in (p.collision for p in own)]
        table.add_row(f"{name}, by {fidelity}", f"{median(each.ms for each in own):.1f}", *cells)
    return table
