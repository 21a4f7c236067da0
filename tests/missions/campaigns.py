"""Campaigns run by `ods missions`, and what they leave."""

from pathlib import Path

from ods.cli import main

RESULTS = ("missions.jsonl", "missions.csv", "summary.json")


def results(campaign: Path, out: str, *more: str) -> list[bytes]:
    """Run a campaign into a folder beside its file; return the files of RESULTS."""
    folder = campaign.parent / out
    assert main(["missions", str(campaign), "--out", str(folder), *more]) == 0
    return [(folder / name).read_bytes() for name in RESULTS]
