"""`benchmarks.missions.fidelities CAMPAIGN.toml`: the same missions by images and by drawn detections, side by side.

Laws of detections are fitted first, in worlds that the campaign does not fly.
"""

import argparse
import tempfile
from pathlib import Path
from statistics import median

from msgspec.structs import replace
from rich.console import Console

from ods.base.settings_file import load
from ods.missions.detections.agreement import compared, table_of
from ods.missions.detections.fit import fitted
from ods.missions.detections.laws import save_laws
from ods.missions.parallel.fly import fly, tasks_of
from ods.missions.parallel.workers import flown_of
from ods.missions.settings import Campaign


def main() -> None:
    """Print a table, and the time a ping of both."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("campaign", type=Path)
    parser.add_argument("--missions", type=int, default=30)
    parser.add_argument("--fit-missions", type=int, default=6)
    parser.add_argument("--workers", type=int, default=1)
    args = parser.parse_args()
    campaign = replace(load(args.campaign, Campaign), missions=args.missions, arms=("ods",))
    with tempfile.TemporaryDirectory() as folder:
        laws = Path(folder) / "laws.json"
        save_laws(fitted(campaign, args.fit_missions)[1], laws)
        runs = [
            list(flown_of(tasks_of(each), fly, args.workers))
            for each in (campaign, replace(campaign, fidelity="detections", detections=laws))
        ]
    console = Console(highlight=False)
    images, detections = ([flown.outcome for flown in run] for run in runs)
    console.print(table_of(compared(images, detections), args.missions))
    for name, run in zip(("pipeline on images", "drawing detections"), runs, strict=True):
        finding, tracking = (
            median(value for value in values if value is not None)
            for values in zip(*((flown.finding_ms, flown.tracking_ms) for flown in run), strict=True)
        )
        console.print(f"{name}: {finding:.2f} ms a ping; tracker {tracking:.2f} ms; {sum(f.cpu_s for f in run):.0f} s")


if __name__ == "__main__":
    main()
