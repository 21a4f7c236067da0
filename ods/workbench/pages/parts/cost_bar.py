"""What the parts of a computation take, as one bar."""

import itertools
from collections.abc import Sequence
from html import escape

COLOURS = ("#56b4e9", "#e69f00", "#009e73", "#cc79a7", "#0072b2", "#d55e00", "#999999", "#f0e442")
"""Okabe and Ito's."""


def cost_bar(parts_us: Sequence[tuple[str, float]], most_us: float) -> str:
    """Return a bar of named times and its legend, as HTML; most_us: that would fill the width."""
    parts = [(escape(name), time_us) for name, time_us in parts_us]
    coloured = list(zip(parts, itertools.cycle(COLOURS), strict=False))
    bars = (
        f'<div class="h-full" style="width: {100.0 * time_us / most_us:.2f}%; background: {colour}" '
        f'title="{name}: {time_us:.0f} µs"></div>'
        for (name, time_us), colour in coloured
    )
    legend = (
        f'<span class="text-xs whitespace-nowrap"><span class="inline-block w-2 h-2 mr-1" style="background: {colour}">'
        f"</span>{name} {time_us:.0f} µs</span>"
        for (name, time_us), colour in coloured
    )
    bar, names = "".join(bars), "".join(legend)
    return f'<div class="flex no-wrap h-4">{bar}</div><div class="flex flex-wrap gap-x-3">{names}</div>'
