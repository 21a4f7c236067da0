"""A run as a moving picture: each ping's image beside the plan, as an animated WebP or GIF."""

from collections.abc import Sequence
from io import BytesIO
from itertools import pairwise
from pathlib import Path

from matplotlib.figure import Figure
from PIL import Image

from ods.base.clock import MS
from ods.base.frames.mounting import Mounting
from ods.offline.picture import View, draw_view

MOST_FRAMES = 120
"""All are in memory while the file is written, 1 MB each."""
SIZE_INCHES, DPI = (11.0, 5.0), 80
FAN_PIXELS = 360
GIF_UNIT_MS = 10
LEAST_MS = 20
"""Browsers show what is to be seen for less as if it were 100 ms: frames are left out instead."""
LAST_MS = 2000
"""Time for which the last frame stands before the movie restarts, ms."""


class Movie:
    """Draws pictures of a run, and writes them as one file. Both inside `drawn_in`."""

    def __init__(self, pings: int, mounting: Mounting) -> None:
        """`pings`: of the whole run; of more than MOST_FRAMES every second, third, ... is shown."""
        self._every = -(-pings // MOST_FRAMES)
        self._mounting = mounting
        self._frames: list[Image.Image] = []
        self._times_ns: list[int] = []

    def wants(self, place: int) -> bool:
        """Return whether the ping at a place of the run is shown."""
        return place % self._every == 0

    def add(self, view: View, t_ns: int) -> None:
        """Draw the state at a time."""
        figure = Figure(figsize=SIZE_INCHES, dpi=DPI)  # a layout engine takes longer than all drawing
        figure.subplots_adjust(left=0.06, right=0.99, bottom=0.1, top=0.92)
        draw_view(figure, view, self._mounting, FAN_PIXELS)
        pixels = BytesIO()
        figure.savefig(pixels, format="rgba", dpi=DPI)
        width, height = (round(DPI * inches) for inches in SIZE_INCHES)
        self._frames.append(Image.frombytes("RGBA", (width, height), pixels.getvalue()).convert("RGB"))
        self._times_ns.append(t_ns)

    def save(self, path: Path) -> None:
        """Write the file, in the mission's own time. Raises OSError, ValueError."""
        if not self._frames:
            raise ValueError("no picture to show")
        places, spans_ms = shown(self._times_ns, GIF_UNIT_MS if path.suffix.lower() == ".gif" else 1)
        first, *others = (self._frames[place] for place in places)
        first.save(path, save_all=True, append_images=others, duration=[*spans_ms, LAST_MS], loop=0)


def shown(times_ns: Sequence[int], unit_ms: int) -> tuple[list[int], list[int]]:
    """Return which frames are shown, and for how long each but the last one, ms: whole units, LEAST_MS or longer.

    Rounded are the times since the first frame, not those of each: errors would add up to minutes.
    """
    since_ms = [round((t_ns - times_ns[0]) / (unit_ms * MS)) * unit_ms for t_ns in times_ns]
    places = [0]
    for place, at_ms in enumerate(since_ms):
        if at_ms - since_ms[places[-1]] >= LEAST_MS:
            places.append(place)
    return places, [since_ms[after] - since_ms[before] for before, after in pairwise(places)]
