"""What a flat and a rough sea-bed's echo cost as the vehicle rolls and pitches: python -m benchmarks.tilted_bed."""

from functools import partial
from pathlib import Path

import numpy as np

from ods.base.frames import geometry
from ods.sim_sonar.echo.bodies import BODY
from ods.sim_sonar.echo.settings import Surface
from ods.sim_sonar.mean_area import Surroundings, mean_area
from ods.sim_sonar.pose import VehiclePose
from ods.sim_sonar.sea_bed.height_field import seeded_field
from ods.sim_sonar.sea_bed.model import make_sea_bed
from ods.sim_sonar.sonar.grid import grid_of
from ods.sim_sonar.sonar.model import load_sonar
from ods.simulate.speed import interleaved_ms

SONARS = ("seabat6012", "seabat6012_3plane", "multibeam512")
TILTS_DEG = ((0.0, 0.0), (3.0, 2.0), (0.0, 10.0), (20.0, 10.0))
"""Roll and pitch."""
HEIGHT_M = 5.0


def main() -> None:
    """Print the table."""
    field = seeded_field(seed=1, rms_m=0.2, correlation_m=3.0, facets=200, facet_m=0.75)
    beds = [make_sea_bed(HEIGHT_M, Surface(), heights) for heights in (None, field)]
    print("| sonar | roll, pitch, deg | flat, ms | rough, ms |\n|---|---|---|---|")
    for name in SONARS:
        grid = grid_of(load_sonar(Path(f"config/sonars/{name}.toml")))
        for roll, pitch in TILTS_DEG:
            pose = VehiclePose(np.zeros(3), geometry.quat_from_euler(np.radians(roll), np.radians(pitch), 0.0))
            scenes = [Surroundings(np.empty(0, BODY), bed) for bed in beds]
            flat, rough = interleaved_ms([partial(mean_area, grid, scene, pose) for scene in scenes])
            print(f"| {name} | {roll:g}, {pitch:g} | {flat:.1f} | {rough:.1f} |")


if __name__ == "__main__":
    main()
