"""The curves of the simulator's menu, as ECharts' options."""

import math
from collections.abc import Sequence
from typing import Any

from nicegui import ui

from ods.workbench.engine.scene.curves import Curve

COLOURS = ("#56b4e9", "#e69f00", "#009e73", "#cc79a7")
"""Told apart by colour-blind eyes, too."""
QUIET = "#8b949e"


def show(chart: ui.echart, options: dict[str, Any]) -> None:
    """Show other options in a chart."""
    chart.options.clear()
    chart.options.update(options)
    chart.update()


def lines(
    curves: Sequence[tuple[str, Curve]], x_name: str, y_names: Sequence[str], *, least: float | None = None,
    dots: Sequence[tuple[float, float]] = (), now: float | None = None,
) -> dict[str, Any]:  # fmt: skip
    """Return a chart of named curves; with two axes' names the second curve has the right one.

    least: lower end of the axis; dots: on the first curve; now: where a line stands.
    """
    series = [_series(name, curve, min(place, len(y_names) - 1)) for place, (name, curve) in enumerate(curves)]
    if dots and series:
        series.append({"type": "scatter", "data": list(dots), "symbolSize": 8, "itemStyle": {"color": COLOURS[0]}})
    if now is not None and series:
        series[0]["markLine"] = {
            "symbol": "none", "label": {"show": False}, "data": [{"xAxis": now}], "lineStyle": {"color": QUIET},
        }  # fmt: skip
    return {
        "animation": False,
        "color": list(COLOURS),
        "textStyle": {"color": QUIET},
        "legend": {
            "show": len(curves) > 1,
            "top": 0,
            "textStyle": {"color": QUIET},
            "data": [name for name, _ in curves],
        },
        "grid": {"left": 54, "right": 54 if len(y_names) > 1 else 16, "top": 46, "bottom": 40},
        "tooltip": {"trigger": "axis"},
        "xAxis": _axis(x_name) | {"nameLocation": "middle", "nameGap": 24, **_ends(curves)},
        "yAxis": [_axis(name, not place) | {"min": least} for place, name in enumerate(y_names)],
        "series": series,
    }


def _ends(curves: Sequence[tuple[str, Curve]]) -> dict[str, int]:
    if not curves:
        return {}
    places = [float(x) for _, curve in curves for x in (curve.x[0], curve.x[-1])]
    return {"min": math.floor(min(places)), "max": math.ceil(max(places))}


def _axis(name: str, grid: bool = True) -> dict[str, Any]:
    return {
        "type": "value", "name": name, "scale": True,
        "axisLine": {"onZero": False, "lineStyle": {"color": QUIET}},
        "axisLabel": {"color": QUIET}, "nameTextStyle": {"color": QUIET},
        "splitLine": {"show": grid, "lineStyle": {"color": QUIET, "opacity": 0.25}},
    }  # fmt: skip


def _series(name: str, curve: Curve, axis: int) -> dict[str, Any]:
    points = [[round(float(x), 3), round(float(y), 4)] for x, y in zip(curve.x, curve.y, strict=True)]
    return {
        "type": "line",
        "name": name,
        "data": points,
        "showSymbol": False,
        "lineStyle": {"width": 1.4},
        "yAxisIndex": axis,
    }


def bars(parts: Sequence[tuple[str, float]], budget: float) -> dict[str, Any]:
    """Return one bar of parts, ms, after another, and a line where the budget ends."""
    series: list[dict[str, Any]] = [
        {"type": "bar", "name": name, "stack": "cost", "data": [round(ms, 3)], "barWidth": 22} for name, ms in parts
    ]
    if series:
        series[-1]["markLine"] = {
            "symbol": "none", "label": {"formatter": "ping period", "color": QUIET}, "data": [{"xAxis": budget}],
        }  # fmt: skip
    return {
        "animation": False,
        "color": list(COLOURS),
        "textStyle": {"color": QUIET},
        "legend": {"top": 0, "textStyle": {"color": QUIET}},
        "grid": {"left": 12, "right": 30, "top": 46, "bottom": 40},
        "tooltip": {"trigger": "item"},
        "xAxis": _axis("CPU time of one image, ms")
        | {"nameLocation": "middle", "nameGap": 24, "max": 30 * math.ceil(0.035 * budget)},
        "yAxis": {"type": "category", "data": [""], "axisTick": {"show": False}},
        "series": series,
    }
