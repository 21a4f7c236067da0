"""The scores of the objects as a table for the terminal."""

from collections.abc import Sequence

from rich.table import Table

from ods.offline.score import ObjectScore


def objects_table(scores: Sequence[ObjectScore]) -> Table:
    """Return one row an object."""
    table = Table("object", "tracked", "position rms", "radius error", "track ids")
    for item in scores:
        table.add_row(
            item.name,
            f"{item.tracked_share:.1%}",
            f"{item.position_rms_m:.2f} m",
            f"{item.radius_error:+.0%}",
            " ".join(map(str, item.ids)),
        )
    return table
