"""Report of a campaign: tables on the terminal, missions.csv, summary.json."""

import csv
from collections.abc import Sequence
from io import StringIO
from pathlib import Path

import msgspec
from rich.table import Table

from ods.base.files.out_file import written_whole
from ods.missions.outcome import Outcome
from ods.missions.settings import Campaign
from ods.missions.statistics import Paired, Rate, Summary, paired, summary_of

ARMS = {"none": "no avoidance", "ods": "the ODS list", "truth": "the truth as list", "all_knowing": "all-knowing"}
SHARES = {("ods", "truth"): ": due to the list", ("truth", "all_knowing"): ": due to the planner"}


class Result(msgspec.Struct, frozen=True):
    """summary.json."""

    arms: list[Summary]
    paired: list[Paired]


def result_of(campaign: Campaign, outcomes: Sequence[Outcome]) -> Result:
    """Sum a campaign up; there is at least one outcome of each arm."""
    straight_m = campaign.world.length_m - campaign.planner.reached_m
    return Result([summary_of(arm, outcomes, straight_m) for arm in campaign.arms], paired(outcomes, campaign.arms))


def write(folder: Path, outcomes: Sequence[Outcome], result: Result) -> None:
    """Write missions.csv and summary.json. Raises OSError."""
    text = StringIO()
    names = [field.name for field in msgspec.structs.fields(Outcome)]
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(names)
    writer.writerows(["" if value is None else value for value in msgspec.structs.astuple(each)] for each in outcomes)
    with written_whole(folder / "missions.csv") as part:
        part.write_text(text.getvalue(), encoding="utf-8")
    with written_whole(folder / "summary.json") as part:
        part.write_bytes(msgspec.json.format(msgspec.json.encode(result), indent=2) + b"\n")


def table_of(result: Result) -> Table:
    """Return one column an arm."""
    table = Table("", *(ARMS[arm.arm] for arm in result.arms))
    for name, key in (("success", "success"), ("collision", "collision"), ("near miss", "near_miss"),
                      ("time-out", "time_out")):  # fmt: skip
        table.add_row(name, *(_rate(getattr(arm, key)) for arm in result.arms))
    table.add_row("smallest clearance, m: median (5 to 95 %)", *(_spread(arm.clearance_m) for arm in result.arms))
    table.add_row("path length relative to a straight line", *(_ratio(arm.path_ratio) for arm in result.arms))
    table.add_row("time relative to no avoidance", *(_ratio(arm.time_ratio) for arm in result.arms))
    table.add_row("path length relative to all_knowing", *(_ratio(arm.path_over_best) for arm in result.arms))
    table.add_row("time relative to all_knowing", *(_ratio(arm.time_over_best) for arm in result.arms))
    table.add_row("time to collision when first listed, s", *(_spread(arm.time_to_collision_s) for arm in result.arms))
    table.add_row("evasions a mission", *(f"{arm.evasions:.1f}" for arm in result.arms))
    table.add_row("of these without an obstacle", *(f"{arm.evasions_of_nothing:.1f}" for arm in result.arms))
    table.add_row("time with no valid list", *(f"{arm.not_valid_share:.1%}" for arm in result.arms))
    return table


def lines_of(result: Result) -> list[str]:
    """Return the paired comparisons, a line each."""
    return [
        f"{ARMS[each.first]} / {ARMS[each.second]}: only the first collides in {each.only_first_collides} worlds, only "
        f"the second in {each.only_second_collides} (McNemar p = {each.p:.2g})"
        f"{SHARES.get((each.first, each.second), '')}"
        for each in result.paired
    ]


def _rate(rate: Rate) -> str:
    return f"{rate.count} of {rate.of}: {rate.share:.1%} ({rate.low:.1%} to {rate.high:.1%})"


def _spread(quantiles: Sequence[float]) -> str:
    return f"{quantiles[2]:.1f} ({quantiles[0]:.1f} to {quantiles[4]:.1f})" if quantiles else "-"


def _ratio(value: float | None) -> str:
    return "-" if value is None else f"{value:.3f}"
