"""Writes the project's own file of pings, .npz. Format in docs/recordings/formats.md."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from ods.base.clock import NS
from ods.messages import Ping, frame_of

COMMON = (
    "beams", "samples", "dtype", "bearing_rad", "elevation_rad", "beam_width_rad", "range0_m", "dr_m", "sound_speed",
    "frequency_hz", "scale", "scale_factor",
)  # fmt: skip
"""Fields of a ping that a file holds once for all pings."""


def write_ping_file(
    path: Path,
    pings: Sequence[Ping],
    position_ned: ArrayLike | None = None,
    attitude: ArrayLike | None = None,
    truth: ArrayLike | None = None,
) -> None:
    """Write pings of one geometry, and what is given of vehicle poses (P, 3), (P, 4) and object truth (P, N, 7).

    Times are left out when all are the same: then nothing is known of them. Raises ValueError when the pings differ in
    geometry or there is none, OSError when the file cannot be written.
    """
    if not pings:
        raise ValueError("no ping to write")
    if any(ping.range_grid is not None for ping in pings):
        raise ValueError(".npz cannot hold range images")
    if any(getattr(ping, name) != getattr(pings[0], name) for ping in pings for name in COMMON):
        raise ValueError("the pings differ in geometry: one .npz holds one geometry")
    arrays = _geometry_arrays(pings[0])
    arrays["frames"] = np.stack([frame_of(ping) for ping in pings])
    if any(ping.no_data for ping in pings):
        arrays["no_data"] = np.array([(index, *run) for index, ping in enumerate(pings) for run in ping.no_data])
    if len({ping.t_ns for ping in pings}) > 1:
        arrays["t"] = np.array([ping.t_ns for ping in pings]) / NS
    given = {"pos_ned": position_ned, "quat": attitude, "truth": truth}
    arrays.update({name: array for name, array in given.items() if array is not None})
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, **{name: np.asarray(array) for name, array in arrays.items()})


def _geometry_arrays(ping: Ping) -> dict[str, ArrayLike]:
    arrays: dict[str, ArrayLike] = {
        "bearing_rad": ping.bearing_rad,
        "range0_m": ping.range0_m,
        "dr_m": ping.dr_m,
        "scale": f"log8:{ping.scale_factor!r}" if ping.scale == "log8" else ping.scale,
        "sound_speed": ping.sound_speed,
    }
    if ping.scale == "db":
        arrays["db_per_count"] = ping.scale_factor
    for name in ("frequency_hz", "elevation_rad", "beam_width_rad"):
        if known := getattr(ping, name):
            arrays[name] = known
    return arrays
