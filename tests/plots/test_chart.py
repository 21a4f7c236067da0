"""What charts share: styles, labels that do not overlap."""

from itertools import combinations
from pathlib import Path

import matplotlib
import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.image import imread
from matplotlib.text import Text

from ods.plots.chart import label_points, save_figure, spread
from ods.plots.style import MARK, PALETTES, SERIES, drawn_in

CORNERS = np.array([[0.0, 0.0], [600.0, 400.0]])


@given(st.lists(st.tuples(st.floats(50.0, 550.0), st.floats(50.0, 350.0)), min_size=1, max_size=8, unique=True))
@settings(max_examples=40, deadline=None)
def test_labels_overlap_neither_each_other_nor_a_point(places: list[tuple[float, float]]) -> None:
    points = np.array(places)
    size = np.array([24.0, 10.0])
    middles = points + spread(points, np.tile(size, (len(points), 1)), points, CORNERS)
    for a, b in combinations(middles, 2):
        assert np.any(np.abs(a - b) >= size - 1e-9)
    for middle in middles:
        assert np.all(np.any(np.abs(points - middle) >= 0.5 * size - 1e-9, axis=1))
        assert np.all((middle - 0.5 * size >= 0.0) & (middle + 0.5 * size <= CORNERS[1]))


def test_lone_label_is_beside_its_point() -> None:
    (offset,) = spread(np.array([[300.0, 200.0]]), np.array([[20.0, 10.0]]), np.array([[300.0, 200.0]]), CORNERS)
    assert np.hypot(*offset) < 25.0


def test_texts_of_a_chart_do_not_overlap_as_drawn() -> None:
    figure = Figure(figsize=(6.0, 4.0), dpi=100)
    axes = figure.subplots()
    crowd = [(str(100 + k), 1.0 + 0.01 * k, 2.0 + 0.003 * k, MARK) for k in range(6)]
    axes.plot([0.0, 3.0], [0.0, 3.0])
    label_points(figure, axes, crowd)
    figure.draw_without_rendering()
    boxes = [Text.get_window_extent(text) for text in axes.texts]  # without the lines to the points
    assert not any(a.overlaps(b) for a, b in combinations(boxes, 2))


@pytest.mark.parametrize("style", PALETTES)
def test_style_colours_paper_and_series_of_the_file_and_ends_with_it(style: str, tmp_path: Path) -> None:
    before = matplotlib.rcParams["figure.facecolor"]
    with drawn_in(style):
        figure = Figure(figsize=(2.0, 2.0), dpi=50)
        axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axes.fill_between([0.0, 1.0], 0.0, 1.0, color=MARK)
        axes.set(xlim=(-1.0, 2.0), ylim=(-1.0, 2.0))
        save_figure(figure, tmp_path / "chart.png")
    assert matplotlib.rcParams["figure.facecolor"] == before
    image = imread(tmp_path / "chart.png")[:, :, :3]
    assert image[2, 2] == pytest.approx(to_rgb(PALETTES[style].paper), abs=0.01)
    assert image[50, 50] == pytest.approx(to_rgb(PALETTES[style].series[0]), abs=0.01)
    assert len(PALETTES[style].series) == len(SERIES)


def luminance(colour: str) -> float:
    """WCAG 2's relative luminance."""
    parts = [c / 12.92 if c <= 0.03928 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
    return float(np.dot(parts, (0.2126, 0.7152, 0.0722)))


@pytest.mark.parametrize("style", PALETTES)
def test_all_colours_can_be_read_on_the_paper(style: str) -> None:
    """WCAG 2: a contrast of 4.5 for text, 3 for graphics."""
    paper, ink, series, _ = PALETTES[style]

    def contrast(colour: str) -> float:
        low, high = sorted((luminance(colour), luminance(paper)))
        return (high + 0.05) / (low + 0.05)

    assert contrast(ink) > 7.0
    assert min(map(contrast, series)) > 3.0
