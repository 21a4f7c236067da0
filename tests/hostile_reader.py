"""Reads damaged copies of a good file, in a process that may take little memory: `python -m tests.hostile_reader NAME`.

Copies are flipped, cut, and inflated: parts of them repeated, numbers in them made huge. A reader may read them or
refuse them in one line of its own; anything else ends this process with a traceback, or by its limits.
"""

import resource
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import msgspec
import numpy as np
from hypothesis import HealthCheck, given, settings, strategies as st

from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.messages import Truth
from ods.nav_bridge.canopen.eds import read_dictionary
from ods.nav_bridge.dbc.file import DbcText
from ods.offline.recorded import pings_of
from ods.offline.truths import TRUTH_SUFFIX, truths_beside
from ods.recording.mcap.reader import open_recording
from ods.recording.summary import summarize
from ods.sim_sonar.scene.settings import SceneFile
from ods.sim_sonar.sea_bed.height_field import load_field
from ods.sonar_link.files.s7k.recorded_poses import read_poses
from ods.tracker.map.store import copy_of_map, open_map
from ods.tracker.scenario import load_scenario
from tests.map.test_command import rock
from tests.recording.mcap_samples import mission, write_segment
from tests.recordings import ARIS, OCULUS
from tests.sonar_link.norbit import wire as norbit
from tests.sonar_link.sonar3d15 import wire as sonar3d15
from tests.sonar_link.test_decoder_oculus_database import database
from tests.sonar_link.test_decoder_oculus_log import BEGUN_S, item, log, messages, packed

CONFIG = Path(__file__).parents[1] / "config"
MORE_BYTES = 1_500_000_000
"""Of addresses that may be taken beyond those of the modules: a reader's bound is 1 GB."""
CPU_S = 240
"""For all copies: no reader goes on without end."""
EXAMPLES = 200
LONGEST_BYTES = 2_000_000


class Reader(NamedTuple):
    """One reader."""

    name: str
    """Of its file."""
    make: Callable[[Path], object]
    """Writes a good file."""
    read: Callable[[Path], object]
    """Raises one of `errors`."""
    errors: tuple[type[Exception], ...] = (OdsError,)


def _pings(path: Path) -> None:
    for _ in pings_of(path).pings:
        pass


def _map(path: Path) -> None:
    store = copy_of_map(path)
    try:
        store.origin_deg(), store.first_free_id(), store.load(), store.load((0.0, 0.0, 100.0))
    finally:
        store.close()


def _new_map(path: Path) -> None:
    store = open_map(path, 57.0, 10.0)
    store.change([rock(number, float(number), 0.0) for number in range(1, 40)], [], 100)
    store.close()


def _recording(path: Path) -> None:
    recording = open_recording(path)
    assert recording.metadata is not None
    assert recording.attachments is not None
    summarize(recording)
    _pings(path)


def _npz(path: Path) -> None:
    np.savez_compressed(
        path, frames=np.arange(600, dtype=np.uint8).reshape(2, 3, 100), t=np.arange(2.0), dr_m=0.1, range0_m=1.0,
        bearing_rad=np.array([-0.1, 0.0, 0.1]), scale="linear",
    )  # fmt: skip


def _scenario(path: Path) -> None:
    zeros = np.zeros((5, 3))
    np.savez_compressed(
        path, t=np.arange(5.0), auv_pos=zeros, auv_rpy=zeros, det=np.array([[0, 9, 0.1, 1, 99.0]]), meta="{}"
    )


def _s7k(path: Path) -> None:
    from ods.cli import main

    assert main(["simulate", str(CONFIG / "scenes/figure11.toml"), "--pings", "2", "--out", str(path)]) == 0


def _viewpoint(path: Path) -> None:
    first, second, _ = messages()
    log(path, item(10, first, BEGUN_S), item(10, packed(second), BEGUN_S + 1.0, 1))


def _viewpoint_database(path: Path) -> None:
    database(path, *((1_700_000_000_000 + number, message) for number, message in enumerate(messages())))


def _new_truths(path: Path) -> None:
    truths = [Truth(number, 5, 5, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0), []) for number in range(20)]
    path.write_bytes(b"\n".join(map(msgspec.json.encode, truths)))


def _truths(path: Path) -> None:
    truths_beside(path.with_suffix("").with_suffix(".npz"))


def _copied(source: Path) -> Callable[[Path], object]:
    return lambda path: path.write_bytes(source.read_bytes())


def _all_messages(path: Path) -> list[object]:
    text = DbcText(path)
    return [text.message(name) for name in text.names]


READERS: dict[str, Reader] = {
    "npz": Reader("a.npz", _npz, _pings),
    "scenario": Reader("a.npz", _scenario, load_scenario),
    "heights": Reader(
        "a.npz",
        lambda path: np.savez_compressed(path, height_m=np.zeros((9, 9)), facet_m=1.0, north_m=0.0, east_m=0.0),
        load_field,
        (OdsError, ValueError),
    ),
    "s7k": Reader("a.s7k", _s7k, _pings),
    "s7k poses": Reader("a.s7k", _s7k, read_poses, (OSError,)),
    "aris": Reader("a.aris", _copied(ARIS), _pings),
    "oculus": Reader("a.raw", _copied(OCULUS), _pings),
    "viewpoint": Reader("a.oculus", _viewpoint, _pings),
    "viewpoint database": Reader("a.oculus", _viewpoint_database, _pings),
    "sonar3d15": Reader("a.sonar", lambda path: path.write_bytes(sonar3d15.packet(sonar3d15.pixels()) * 2), _pings),
    "norbit": Reader("a.wbms", lambda path: path.write_bytes(norbit.image(norbit.samples(1))), _pings),
    "mcap": Reader("a.mcap", lambda path: write_segment(path, mission(3), attachments={"a": b"b"}), _recording),
    "map": Reader("a.sqlite", _new_map, _map),
    "config": Reader("a.toml", _copied(CONFIG / "onboard.toml"), lambda path: load(path, OnboardConfig)),
    "scene": Reader("a.toml", _copied(CONFIG / "scenes/figure11.toml"), lambda path: load(path, SceneFile)),
    "eds": Reader("a.eds", _copied(CONFIG / "ins.eds"), lambda path: read_dictionary(path, 5, "nav")),
    "dbc": Reader("a.dbc", _copied(CONFIG / "sbg.dbc"), _all_messages),
    "truths": Reader(f"a{TRUTH_SUFFIX}", _new_truths, _truths),
}


@st.composite
def damaged(draw: st.DrawFn, whole: bytes) -> bytes:
    """Flip, cut, repeat, and put the largest numbers in."""
    content = bytearray(whole)
    for _ in range(draw(st.integers(1, 4))):
        at = draw(st.integers(0, max(0, len(content) - 1)))
        kind = draw(st.sampled_from(("flip", "cut", "repeat", "huge", "digits")))
        if kind == "flip" and content:
            content[at] ^= draw(st.integers(1, 255))
        elif kind == "cut":
            del content[at : at + draw(st.sampled_from((1, 8, 1000, len(content))))]
        elif kind == "repeat":
            part = bytes(content[at : at + draw(st.integers(1, 300))])
            content[at:at] = part * (LONGEST_BYTES // (4 * max(1, len(part))))
        elif kind == "huge":
            size = draw(st.sampled_from((2, 4, 8)))
            content[at : at + size] = draw(
                st.sampled_from((b"\xff" * size, b"\xff" * (size - 1) + b"\x7f", bytes(size)))
            )
        else:
            content[at : at + 1] = b"999999999999"
    return bytes(content[:LONGEST_BYTES])


def attack(reader: Reader, folder: Path) -> None:
    """Read many damaged copies. Raises what the reader must not raise."""
    path = folder / reader.name
    reader.make(path)
    reader.read(path)
    whole = path.read_bytes()

    @settings(
        max_examples=EXAMPLES, deadline=None, database=None, derandomize=True, suppress_health_check=list(HealthCheck)
    )
    @given(damaged(whole))
    def read(content: bytes) -> None:
        path.write_bytes(content)
        try:
            reader.read(path)
        except reader.errors as error:
            assert "\n" not in str(error)  # noqa: PT017  one line is what is tested

    read()


def bound() -> None:
    """Let this process take no more memory and time than a reader may."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    limits: dict[Any, int] = {
        resource.RLIMIT_AS: pages * resource.getpagesize() + MORE_BYTES,
        resource.RLIMIT_CPU: CPU_S,
    }
    for kind, most in limits.items():
        resource.setrlimit(kind, (most, most))


if __name__ == "__main__":
    bound()
    with tempfile.TemporaryDirectory() as place:
        attack(READERS[sys.argv[1]], Path(place))
