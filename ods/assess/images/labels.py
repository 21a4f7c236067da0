"""Labels of recorded frames: a text file of boxes beside the recording."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ods.assess.images.labelled import LabelledImage, Target
from ods.base.errors import OdsError
from ods.base.files.in_file import text_of
from ods.messages import Ping


def read_labels(path: Path, pings: Sequence[Ping]) -> list[LabelledImage]:
    """Return the frames of a recording that path has labels of.

    A line is: place of the frame in the recording, first and last beam, first and last sample, and what it looks like;
    `#` begins a comment. Raises OdsError, which names the line.
    """
    boxes: dict[int, list[Target]] = {}
    try:
        lines = text_of(path).splitlines()
    except OSError as error:
        raise OdsError(f"{path}: {error.strerror}") from error
    except UnicodeDecodeError as error:
        raise OdsError(f"{path}: no labels: not UTF-8 text") from error
    for number, line in enumerate(lines, 1):
        text = line.partition("#")[0].split()
        if not text:
            continue
        try:
            frame, *box = (int(word) for word in text[:5])
            boxes.setdefault(frame, []).append(_target(pings[frame], *box))
        except (ValueError, TypeError, IndexError) as error:
            raise OdsError(f"{path}:{number}: not `frame beam beam sample sample` of the recording") from error
    return [LabelledImage(pings[frame], targets) for frame, targets in sorted(boxes.items())]


def _target(ping: Ping, first_beam: int, last_beam: int, first_sample: int, last_sample: int) -> Target:
    if not (0 <= first_beam <= last_beam < ping.beams and 0 <= first_sample <= last_sample < ping.samples):
        raise ValueError
    bearing = np.array(ping.bearing_rad)
    return Target(
        (ping.range0_m + ping.dr_m * first_sample, ping.range0_m + ping.dr_m * last_sample),
        (float(bearing[first_beam]), float(bearing[last_beam])),
    )
