"""Several pings on one picture, all on the same colour scale."""

import math
from collections.abc import Sequence
from typing import NamedTuple

from matplotlib.figure import Figure

from ods.messages import Detections, Ping
from ods.plots.fan import aspect_of, draw_detections, draw_fan_image, limits_of, polar_image, style_colour_bar

PIXELS = 500
"""Of the longer side of a fan on a sheet."""
HEIGHT = 3.0
"""Of a fan, inches."""


class SheetItem(NamedTuple):
    """One ping of a sheet."""

    title: str
    ping: Ping
    found: Detections


def sheet_figure(items: Sequence[SheetItem]) -> Figure:
    """Return the picture of some dozens of pings at most with their detections.

    Raises ValueError when a ping's buffer does not fit its shape.
    """
    images = [polar_image(item.ping) for item in items]
    width = min(max(2.2, HEIGHT * max(aspect_of(image.bearing_rad) for image in images) + 0.5), 9.0)
    columns = math.ceil(math.sqrt(len(items) * HEIGHT / width))
    rows = math.ceil(len(items) / columns)
    size = 1.6 + width * columns, 0.5 + (HEIGHT + 0.5) * rows
    figure = Figure(figsize=size, dpi=100, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False)
    limits = [limits_of(image, PIXELS) for image in images]
    shared = min(low for low, _ in limits), max(high for _, high in limits)
    for panel, item, image in zip(axes.flat, items, images, strict=False):
        picture = draw_fan_image(panel, image, shared, PIXELS)
        draw_detections(panel, item.found.detections)
        panel.set_title(item.title, fontsize=10)
        panel.tick_params(labelsize=8)
        panel.label_outer()
    for panel in axes.flat[len(items) :]:
        panel.set_axis_off()
    style_colour_bar(figure.colorbar(picture, ax=axes.ravel().tolist(), shrink=0.6, pad=0.01), "level, dB")
    return figure
