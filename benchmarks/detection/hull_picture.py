"""`benchmarks.detection.hull_picture docs/sonars/sonar3d15.png`: a real range image of a hull, and its circles."""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from ods.base.frames.geometry import polar_to_body
from ods.messages import frame_of
from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.sonar_link.files.opening import open_pings

RECORDING = Path(__file__).parents[2] / "tests" / "data" / "sonar3d15" / "ship_short.sonar"
NUMBER = 2
FARTHEST_M = 7.0


def main() -> None:
    """Draw it."""
    ping = open_pings(RECORDING).pings[NUMBER]
    assert ping.range_grid is not None
    mask = np.zeros((ping.beams, ping.samples), np.int32)
    found = Chain(PipelineSettings()).process(ping, mask).detections
    range_m = frame_of(ping).astype(np.float64) * ping.dr_m
    bearing, elevation = np.array(ping.bearing_rad), np.array(ping.range_grid.elevation_rad)
    points = polar_to_body(range_m, bearing[:, None], elevation[None, :])
    figure = Figure(figsize=(10.0, 4.2), layout="constrained")
    image, plan = figure.subplots(1, 2, width_ratios=[1.5, 1.0])
    borders = [*np.degrees(bearing[[0, -1]]), *np.degrees(elevation[[0, -1]])]
    shown = np.where(range_m > 0.0, range_m, np.nan).T
    drawn = image.imshow(shown, origin="lower", extent=borders, vmin=1.5, vmax=FARTHEST_M, cmap="viridis_r")
    figure.colorbar(drawn, ax=image, label="range, m", location="bottom", shrink=0.7)
    image.set(xlabel="bearing, degrees", ylabel="elevation, degrees", title="range image")
    hit = points[mask > 0]
    dots = plan.scatter(hit[:, 1], hit[:, 0], c=-hit[:, 2], s=1.0, cmap="coolwarm", vmin=-2.0, vmax=2.0)
    figure.colorbar(dots, ax=plan, label="height over the sonar, m")
    for each in found:
        ahead, aside, _ = polar_to_body(each.range_m, each.bearing_rad, each.elevation_rad)
        plan.add_patch(Circle((aside, ahead), each.radius_m, fill=False, lw=0.6))
    plan.set(xlabel="to starboard, m", ylabel="ahead, m", title="seen from above, with circles", aspect="equal")
    figure.savefig(Path(sys.argv[1]), dpi=110)


if __name__ == "__main__":
    main()
