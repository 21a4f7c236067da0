"""Labels of one's own: as `ods assess detect` reads them, and what a chain finds of them."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ods.assess.images.labels import Box, read_boxes, target_of, text_of_boxes
from ods.messages import Detections, Ping
from ods.workbench.engine.data import open_data
from ods.workbench.engine.files.folders import readable, write_whole
from ods.workbench.engine.ping.truth import Judged, TrueCircle, is_processed
from ods.workbench.model.state import Label, State


def write(file: Path, state: State) -> None:
    """Write the labels of a state. Raises OdsError."""
    recording = Path(state.data.path).name
    about = f"Labels of {recording}: ods assess detect --own --real {recording} {file.name}"
    boxes = [Box(each.ping, *each.beams, *each.samples, each.text) for each in state.labels]
    write_whole(file, text_of_boxes(boxes, about).encode())


def read(path: str | Path, state: State, folders: Sequence[Path]) -> tuple[Label, ...]:
    """Return the labels that a file has of the recording of a state. Raises OdsError, which names the line."""
    data = open_data(state.data, state.scene, folders)
    return tuple(
        Label(
            box.frame, (box.first_beam, box.last_beam), (box.first_sample, box.last_sample),
            text="".join(filter(str.isprintable, box.words))[:80],
        )
        for box in read_boxes(readable(path, folders), data.pings)
    )  # fmt: skip


def of_ping(labels: Sequence[Label], place: int, ping: Ping) -> list[tuple[int, Label]]:
    """Return the labels of a ping with their places among all; none that do not fit it, as a link may bring."""
    return [
        (at, each)
        for at, each in enumerate(labels)
        if each.ping == place and each.beams[1] < ping.beams and each.samples[1] < ping.samples
    ]


def judged_by(detections: Detections, labels: Sequence[Label], ping: Ping) -> tuple[list[TrueCircle], Judged]:
    """Return the labels of a ping as circles, and the detections against them, as `ods assess detect` counts: a label
    is found by any detection whose centre lies in its box; others in a box are neither right nor false."""
    targets = [target_of(ping, Box(0, *each.beams, *each.samples, each.text)) for each in labels]
    found = detections.detections
    inside = [[at for at, each in enumerate(found) if target.holds(each)] for target in targets]
    right = [(those[0], place) for place, those in enumerate(inside) if those]
    first, any_of = {at for at, _ in right}, {at for those in inside for at in those}
    circles = [_circle(each, ping) for each in labels]
    missed = [place for place, those in enumerate(inside) if not those and is_processed(detections, circles[place])]
    return circles, Judged(
        right, sorted(any_of - first), [at for at in range(len(found)) if at not in any_of], missed
    )  # fmt: skip


def _circle(label: Label, ping: Ping) -> TrueCircle:
    near_m, far_m = (ping.range0_m + ping.dr_m * sample for sample in label.samples)
    port, starboard = (float(ping.bearing_rad[beam]) for beam in label.beams)
    range_m = 0.5 * (near_m + far_m)
    radius_m = max(0.5 * (far_m - near_m), range_m * float(np.sin(0.5 * (starboard - port))), ping.dr_m)
    return TrueCircle(label.text or "label", range_m, 0.5 * (port + starboard), radius_m, True)
