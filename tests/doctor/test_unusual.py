"""Values that are allowed, but surely a mistake, are named with what they do."""

from pathlib import Path

import pytest

from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.doctor.unusual import examine

CONFIG = Path(__file__).parents[2] / "config"


def said(tmp_path: Path, table: str, text: str) -> list[str]:
    """Return what is said of a configuration with more keys in one of its tables."""
    content = (CONFIG / "onboard.toml").read_text(encoding="utf-8")
    content = content.replace('"ins.eds"', f'"{CONFIG / "ins.eds"}"')
    file = tmp_path / "onboard.toml"
    where = f"[{table}]"
    file.write_text(
        content.replace(where, f"{where}\n{text}\n", 1) if where in content else f"{content}\n{where}\n{text}"
    )
    return [finding.text for finding in examine(load(file, OnboardConfig))]


@pytest.mark.parametrize("file", sorted(CONFIG.glob("onboard*.toml")), ids=lambda file: file.stem)
def test_the_shipped_configurations_are_usual(file: Path) -> None:
    assert list(examine(load(file, OnboardConfig))) == []


@pytest.mark.parametrize(
    ("table", "text", "reported"),
    [
        (
            "tracker.bottom", "clearance_m = 500",
            "tracker.bottom.clearance_m = 500 is unusual, 0.1 to 10 m is usual: "
            "An object that rises higher above the bottom is an obstacle",
        ),
        (
            "pipeline", "smallest_object_m = 50",
            "pipeline.smallest_object_m = 50 is unusual, 0 to 5 m is usual: Smallest object that matters",
        ),
        (
            "sonar", "latency_ms = 40000",
            "sonar.latency_ms = 40000 is unusual, -50 to 1000 ms is usual: From the last echo's arrival",
        ),
        (
            "tracker.planner", "lead_times_s = [5, 5000]",
            "tracker.planner.lead_times_s = 5000 is unusual, 0 to 120 s is usual: Times ahead",
        ),
        ("sonar.mounting", "position_m = [37, 0, 0]", "sonar.mounting.position_m = 37 is unusual, -20 to 20 m"),
        ("nav.sigma", "attitude_rad = 1.5", "nav.sigma.attitude_rad = 1.5 is unusual, 0.0001 to 0.2 rad is usual"),
        (
            "[pipeline.stage]", 'use = "equalize.mean_range"\nwindow = 5000',
            "pipeline.stage[0].window = 5000 is unusual, 10 to 400 samples is usual: Surroundings, range samples",
        ),
    ],
)  # fmt: skip
def test_one_line_names_key_value_what_is_usual_and_what_it_does(
    tmp_path: Path, table: str, text: str, reported: str
) -> None:
    (line,) = said(tmp_path, table, text)
    assert line.startswith(reported)
    assert "\n" not in line
