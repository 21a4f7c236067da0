"""A leniency: polar images as others save them, under their own array names, are read as a file of pings.

They have `bearings_deg`, `dr`, and perhaps `range0`, `t_us`, `c`, `freq`; frames may be sample by sample. Without
`range0` the first sample lies at range 0, without `scale` amplitudes are linear.
"""

import numpy as np

from ods.base.arrays import AnyArray

Arrays = dict[str, AnyArray]

_OTHER_NAMES = {
    "bearings_deg": ("bearing_rad", np.pi / 180.0),
    "dr": ("dr_m", 1.0),
    "range0": ("range0_m", 1.0),
    "t_us": ("t", 1e-6),
    "c": ("sound_speed", 1.0),
    "freq": ("frequency_hz", 1.0),
}
"""Their name: our name, factor to our unit."""


def translate(arrays: Arrays) -> Arrays:
    """Return the arrays under this project's names and units; unchanged when they have them.

    Raises ValueError when there is no beam table under either name.
    """
    if "bearing_rad" in arrays:
        return arrays
    if "bearings_deg" not in arrays:
        raise ValueError("no array `bearing_rad` (nor `bearings_deg`): without a beam table there is no geometry")
    ours: Arrays = {"scale": np.asarray("linear"), "range0_m": np.asarray(0.0)}
    for name, array in arrays.items():
        if name not in _OTHER_NAMES:
            ours[name] = array
        elif array.dtype.kind in "fiu":
            our_name, factor = _OTHER_NAMES[name]
            ours[our_name] = array.astype(np.float64) * factor
        else:
            raise ValueError(f"{name}: not numbers")
    return ours
