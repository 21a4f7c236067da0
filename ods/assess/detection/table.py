"""The table of all settings, and what each attention costs in it."""

from collections.abc import Iterator, Sequence

import numpy as np
from rich.table import Table

from ods.assess.detection.chains import ATTENTION
from ods.assess.detection.measure import SettingRow


def setting_table(rows: Sequence[SettingRow], front: Sequence[int]) -> Table:
    """Return the table of all settings, numbered as in the chart, those on the front marked."""
    table = Table(title="at 1 false alarm an image (tank: 4); * on the Pareto front of the simulated sea")
    for heading in ("setting", "ms", "Pd sea", "position, m", "radius", "Pd tank", "noise, dB", "edges"):
        table.add_column(heading, justify="left" if heading == "setting" else "right")
    for index, row in enumerate(rows):
        table.add_row(
            f"{'*' if index in front else ' '} {index:2d} {row.name}",
            f"{row.ms:.3f}",
            f"{row.sea.detection_probability:.3f}",
            f"{row.sea.position_error_m:.2f}",
            f"{row.sea.radius_error:.0%}",
            f"{row.tank.detection_probability:.3f}",
            f"{row.noise_db:.1f}",
            f"{row.edges:.2f}",
        )
    return table


def attention_costs(rows: Sequence[SettingRow]) -> Iterator[str]:
    """Yield what each attention costs and saves: means over all settings that were measured with it and without."""
    by_name = {row.name: row for row in rows}
    for attention in filter(None, ATTENTION):
        ending = f", {attention}"
        pairs = [(whole, by_name[name + ending]) for name, whole in by_name.items() if name + ending in by_name]
        if pairs:
            sea = np.mean([part.sea.detection_probability - whole.sea.detection_probability for whole, part in pairs])
            tank = np.mean(
                [part.tank.detection_probability - whole.tank.detection_probability for whole, part in pairs]
            )
            ms = np.median([part.ms / whole.ms for whole, part in pairs])
            yield f"{attention}: Pd sea {sea:+.3f}, tank {tank:+.3f}, {ms:.2f} times the time ({len(pairs)} settings)"
