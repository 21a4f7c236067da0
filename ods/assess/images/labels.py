"""Labels of recorded frames: a text file of boxes beside the recording."""

from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from ods.assess.images.labelled import LabelledImage, Target
from ods.base.errors import OdsError
from ods.base.files.in_file import text_of
from ods.messages import Ping


class Box(NamedTuple):
    """A line of the file."""

    frame: int
    """Its place in the recording."""
    first_beam: int
    last_beam: int
    first_sample: int
    last_sample: int
    words: str
    """What it looks like."""


def read_labels(path: Path, pings: Sequence[Ping]) -> list[LabelledImage]:
    """Return the frames of a recording that path has labels of. Raises OdsError, which names the line."""
    boxes: dict[int, list[Target]] = {}
    for box in read_boxes(path, pings):
        boxes.setdefault(box.frame, []).append(target_of(pings[box.frame], box))
    return [LabelledImage(pings[frame], targets) for frame, targets in sorted(boxes.items())]


def read_boxes(path: Path, pings: Sequence[Ping]) -> Iterator[Box]:
    """Yield what a file labels in a recording.

    A line is: place of the frame in the recording, first and last beam, first and last sample, and what it looks like;
    `#` begins a comment. Raises OdsError, which names the line.
    """
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
            frame, first_beam, last_beam, first_sample, last_sample = (int(word) for word in text[:5])
            box = Box(frame, first_beam, last_beam, first_sample, last_sample, " ".join(text[5:]))
            _fit(box, pings[frame])
        except (ValueError, IndexError) as error:
            raise OdsError(f"{path}:{number}: not `frame beam beam sample sample` of the recording") from error
        yield box


def text_of_boxes(boxes: Iterable[Box], about: str) -> str:
    """Return boxes as the text of such a file. about: one line of comment."""
    head = f"# {about}\n# frame, first and last beam (0 = port), first and last sample, what it looks like\n"
    return head + "".join(" ".join(map(str, box)).rstrip() + "\n" for box in boxes)


def target_of(ping: Ping, box: Box) -> Target:
    """Return what a detection's centre must lie in."""
    return Target(
        (ping.range0_m + ping.dr_m * box.first_sample, ping.range0_m + ping.dr_m * box.last_sample),
        (float(ping.bearing_rad[box.first_beam]), float(ping.bearing_rad[box.last_beam])),
    )


def _fit(box: Box, ping: Ping) -> None:
    beams, samples = (box.first_beam, box.last_beam), (box.first_sample, box.last_sample)
    if not (0 <= beams[0] <= beams[1] < ping.beams and 0 <= samples[0] <= samples[1] < ping.samples):
        raise ValueError
