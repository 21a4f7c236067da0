"""Planners in C, C++ and JavaScript receive a real publisher; the header takes no message for a list that is none."""

import json
import os
import random
import shutil
import subprocess
import tempfile
import threading
from collections.abc import Iterator
from pathlib import Path

import msgspec
import pytest
import zmq

from ods.messages import ClosestApproach, ObstacleList, Prediction, Site
from ods.runtime import bus
from tests.client.compiled import CLIENT, ROOT, compiled
from tests.client.test_ahead import MOVING
from tests.client.test_near_misses import RESTING, seen_from

EXAMPLES = ROOT / "docs" / "examples" / "integrator"
UTC_NS = 1_795_791_275_823_067_741
TOLD = msgspec.structs.replace(
    seen_from(
        msgspec.structs.replace(
            MOVING, cpa=ClosestApproach(1.0, 2.0, 0.5), predicted=[Prediction(5.0, (1.0, 2.0, 3.0), (1.0, 1.0, 1.0))]
        ),
        msgspec.structs.replace(RESTING, id=2**31 - 1),
        place=(12.5, -7.25),
    ),
    utc_ns=UTC_NS, site=Site(57.5, -10.25), heard_from_db=None,
)  # fmt: skip
POSITIONS = [[30.0, -2.0, 9.0], [40.0, 0.0, 9.0]]
READ = r"""
#include <stdio.h>
#include <stdlib.h>
#include "ods_list.h"
/* Reads messages, each with its length of 4 bytes before it; prints for each whether it is a list, and a sum of it. */
int main(void) {
    static OdsObstacle obstacles[4];
    unsigned char length[4];
    while (fread(length, 1, 4, stdin) == 4) {
        size_t size = (size_t)length[0] << 24 | (size_t)length[1] << 16 | (size_t)length[2] << 8 | length[3];
        unsigned char *bytes = malloc(size + 1); /* of this size: a sanitizer sees what is read beyond */
        if (fread(bytes, 1, size, stdin) != size) return 1;
        unsigned char *exact = malloc(size ? size : 1);
        memcpy(exact, bytes, size);
        OdsList list;
        int good = ods_read_list(exact, size, &list, obstacles, 4);
        printf("%d %d %d %s\n", good, good ? list.valid : 0, good ? (int)list.obstacles : 0, good ? list.reason : "");
        free(bytes);
        free(exact);
    }
    return 0;
}
"""


@pytest.fixture
def run_dir() -> Iterator[Path]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        yield Path(folder)


def received(command: list[str], run_dir: Path, lists: int = 3) -> list[dict[str, object]]:
    """Return what a planner prints of `lists` lists, while TOLD is published until it has ended."""
    context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
    publisher = bus.Publisher(context, run_dir, "tracker")
    planner = subprocess.Popen([*command, str(run_dir), str(lists)], stdout=subprocess.PIPE, text=True)
    done = threading.Event()
    limit = threading.Timer(60.0, planner.kill)
    limit.start()
    try:
        while planner.poll() is None:
            publisher.publish("obstacles", TOLD)
            done.wait(0.05)
    finally:
        limit.cancel()
        publisher.close()
        context.term()
    assert planner.stdout is not None
    assert planner.returncode == 0
    return [json.loads(line) for line in planner.stdout]


def test_cpp_hears_the_list_complete(run_dir: Path, tmp_path: Path) -> None:
    program = compiled("c++", CLIENT / "planner.cpp", tmp_path, "-std=c++17")
    last = received([str(program)], run_dir)[-1]
    assert last == {
        "valid": True, "utc_ns": UTC_NS, "site": [57.5, -10.25], "vehicle": [12.5, -7.25], "ids": [7, 2**31 - 1],
        "positions": POSITIONS,
    }  # fmt: skip


def test_c_hears_the_obstacles(run_dir: Path, tmp_path: Path) -> None:
    program = compiled("cc", EXAMPLES / "planner.c", tmp_path, "-std=c99")
    assert received([str(program)], run_dir)[-1] == {"valid": True, "positions": POSITIONS}


def test_javascript_hears_the_obstacles(run_dir: Path) -> None:
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node here")
    last = received([node, str(EXAMPLES / "planner.js")], run_dir)[-1]
    assert last == {"valid": True, "reasons": [], "positions": POSITIONS}


def said_without_a_list(command: list[str], run_dir: Path, user: int | None = None) -> str:
    """Return what a planner says while it receives nothing, its first line on the error output."""
    with subprocess.Popen(
        [*command, str(run_dir), "1"], stderr=subprocess.PIPE, text=True, user=user, group=user
    ) as run:
        limit = threading.Timer(60.0, run.kill)
        limit.start()
        assert run.stderr is not None
        said = run.stderr.readline().rstrip()
        limit.cancel()
        run.kill()
    return said


@pytest.mark.parametrize("language", ["c", "c++", "javascript"])
def test_a_refused_socket_is_no_silence(run_dir: Path, tmp_path: Path, language: str) -> None:
    if language == "javascript":
        node = shutil.which("node")
        if node is None:
            pytest.skip("no node here")
        command = [node, str(EXAMPLES / "planner.js")]
    else:
        compiler, source, standard = ("cc", EXAMPLES / "planner.c", "-std=c99")
        if language == "c++":
            compiler, source, standard = ("c++", CLIENT / "planner.cpp", "-std=c++17")
        command = [str(compiled(compiler, source, tmp_path, standard))]
    file = run_dir / "tracker.sock"
    assert said_without_a_list(command, run_dir) == f"{file}: no socket: does the tracker run?"
    if language != "javascript":
        context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        publisher = bus.Publisher(context, run_dir, "tracker")
        assert said_without_a_list(command, run_dir) == f"{file}: the tracker is there, and silent"
        publisher.close()
        context.term()
    if os.geteuid() == 0:
        with tempfile.TemporaryDirectory(prefix="ods-") as folder:
            Path(folder).chmod(0o755)
            (Path(folder) / "run").mkdir(mode=0o750)
            program = Path(folder) / "planner"  # where others may run it
            if language != "javascript":
                shutil.copy(command[0], program)
                command = [str(program)]
            else:
                command[1] = str(shutil.copy(Path(command[1]), program))
            place = Path(folder) / "run"
            said = said_without_a_list(command, place, user=65534)
            assert said == f"{place / 'tracker.sock'}: no right to open the socket: join its group"


def read_by_header(messages: list[bytes], folder: Path) -> list[str]:
    (folder / "read.c").write_text(READ)
    program = compiled("cc", folder / "read.c", folder, "-std=c99", "-fsanitize=address,undefined", "-static-libasan")
    stream = b"".join(len(each).to_bytes(4, "big") + each for each in messages)
    done = subprocess.run([program], input=stream, capture_output=True, check=False)
    assert done.returncode == 0, done.stderr.decode()
    assert not done.stderr
    return done.stdout.decode(errors="replace").splitlines()


def test_the_header_takes_nothing_for_a_list_that_is_none_and_reads_no_byte_beyond(tmp_path: Path) -> None:
    whole = msgspec.msgpack.encode(TOLD)
    plain = msgspec.to_builtins(TOLD)
    long = plain | {"valid": False, "reasons": ["é" * 400, "more"], "obstacles": plain["obstacles"] * 5}
    wrong = [
        b"", b"\xc0", b"\x80", msgspec.msgpack.encode([TOLD]), msgspec.msgpack.encode({"valid": True}),
        msgspec.msgpack.encode(plain | {"obstacles": 3}), msgspec.msgpack.encode(plain | {"t_ns": "now"}),
        msgspec.msgpack.encode(plain | {"obstacles": [{"radius_m": float("nan")}]}),
        b"\x81\xa1x" + b"\x91" * 100_000, b"\xdf\xff\xff\xff\xff", b"\x81\xdb\xff\xff\xff\xffx",
    ]  # fmt: skip
    cut = [whole[:k] for k in range(len(whole))]
    rng = random.Random(5)
    bent = [bytearray(whole) for _ in range(2000)]
    for each in bent:
        each[rng.randrange(len(each))] = rng.randrange(256)
    said = read_by_header([whole, msgspec.msgpack.encode(long), *wrong, *cut, *map(bytes, bent)], tmp_path)
    assert said[0] == "1 1 2 "
    assert said[1].startswith("1 0 10 é")
    assert set(said[2 : 2 + len(wrong) + len(cut)]) == {"0 0 0 "}


def test_a_list_of_before_is_read(tmp_path: Path) -> None:
    plain = msgspec.to_builtins(TOLD)
    for name in ("site", "pose", "head", "sector", "made_utc_ns"):
        del plain[name]
    assert read_by_header([msgspec.msgpack.encode(msgspec.convert(plain, ObstacleList))], tmp_path) == ["1 1 2 "]
