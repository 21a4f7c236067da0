"""Tasks of tuning: a threshold, three filters on one beam, A against B, what is tuned saved and run."""

import re
from pathlib import Path

import pytest

from ods.base.settings_file import load
from ods.config import OnboardConfig
from tests.workbench.browser.hand import Hand
from tests.workbench.browser.tasks.conftest import counted, run_on_the_bench
from tests.workbench.browser.waiting import TEXT, until

pytestmark = pytest.mark.slow


def open_figure_11(hand: Hand) -> None:
    hand.press("Open")
    hand.press("scenes of ODS")
    hand.press("figure11.toml")
    hand.sees("against the truth: 3 right")


def false_ones(hand: Hand) -> int:
    """Return how many false ones the page counts."""
    found = re.search(r"against the truth: \d+ right, (\d+) false", hand.window.execute_script(TEXT))
    return int(found[1]) if found else 0


def test_a_threshold_is_lowered_until_false_ones_appear(hand: Hand) -> None:
    open_figure_11(hand)
    before = false_ones(hand)
    hand.write("high level", "4", enter=True)
    until(lambda: false_ones(hand) > before + 2)
    counted(hand, "A threshold until false ones appear")


def test_three_filters_are_compared_on_one_beam(hand: Hand) -> None:
    open_figure_11(hand)
    hand.press("keep as B")
    hand.press("remove", "4 filter.fir")
    hand.press("add stage")
    hand.press("filter.wiener")
    hand.press("keep as C")
    hand.press("remove", "4 filter.wiener")
    hand.press("add stage")
    hand.press("filter.median")
    hand.sees("A: after 4 filter.median, B: after 4 filter.fir, C: after 4 filter.wiener")
    counted(hand, "Three filters on one beam")


def test_a_is_compared_with_b(hand: Hand) -> None:
    open_figure_11(hand)
    hand.press("keep as B")
    hand.write("high level", "4", enter=True)
    hand.press("difference")
    heading = "return [...document.querySelectorAll('div')].find((one) => one.fanView).fanView.heading()"
    until(lambda: re.search(r"\d+ both, [1-9]\d* only A, 0 only B", hand.window.execute_script(heading)))
    counted(hand, "A against B")


def test_what_is_tuned_is_saved_and_runs(hand: Hand, folder: Path) -> None:
    open_figure_11(hand)
    hand.write("high level", "6", enter=True)
    hand.press("Utilities")
    hand.sees("1 setting differs")
    hand.press("Save", "Configuration for the vehicle")
    tuned = folder / "onboard-tuned.toml"
    hand.sees(f"written: {tuned}")
    counted(hand, "Save, and run on board")
    chain = load(tuned, OnboardConfig).pipeline.chain()
    assert (chain[-1]["use"], chain[-1]["high"]) == ("detect.two_level", 6.0)
    assert run_on_the_bench("--onboard", tuned, 8) == 0
