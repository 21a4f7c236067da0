"""Makes the recordings of the regression tests anew, by the real processes: `python -m tests.replay.recordings`.

That is how they are updated, on purpose: after a change of what detections or lists say. Two missions of the bench with
a small sonar: figure 11 of [SSIE], and one whose processes are killed and whose INS falls silent.
"""

import sys
import tempfile
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import msgspec
import zmq

from ods.base import clock
from ods.base.settings_file import load
from ods.bench.runner import fly_mission
from ods.bench.settings import BenchConfig
from ods.recording.facts import facts
from ods.recording.mcap.segment import Logged, Segment
from ods.runtime.bus import endpoint
from ods.runtime.processes import PROCESSES, SUPERVISOR

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "tests" / "data" / "replay"
SONAR = """# 45 degrees to either side and 100 m far, with few samples: recordings of it are small
name = "small"
frequency_hz = 455000.0
sound_speed = 1500.0
beams_per_plane = 30
beam_spacing_deg = 3.0
beam_width_deg = 3.0
side_lobe_db = -25.0
half_vertical_deg = 10.0
range0_m = 0.2
dr_m = 0.2
samples = 500
overhead_s = 0.016
"""
SECONDS = {"figure11": 15.0, "faults": 24.0}
KILLED = {"pipeline": 5.0, "tracker": 11.0, "nav": 17.0}
SILENT = {"kind": "ins_silent", "at_s": 21.0, "for_s": 1.0}


def bench_config(name: str, folder: Path) -> BenchConfig:
    """Return a mission of the bench that leaves its results in a folder."""
    file = ROOT / "config" / {"figure11": "bench.toml", "faults": "bench-faults.toml"}[name]
    config = load(file, BenchConfig)
    (folder / "small.toml").write_text(SONAR)
    changes = msgspec.to_builtins(config, enc_hook=str)
    changes |= {"seconds": SECONDS[name], "out": str(folder / "out"), "bus": {"run_dir": str(folder / "run")}}
    changes["sim"]["sonar"] = str(folder / "small.toml")
    if name == "faults":
        changes["kill"] = [{"process": process, "at_s": at_s} for process, at_s in KILLED.items()]
        changes["sim"]["fault"] = [SILENT]
    return msgspec.convert(changes, BenchConfig, dec_hook=lambda kind, text: kind(text))


@contextmanager
def listening(run_dir: Path, received: list[Logged]) -> Iterator[None]:
    """Keep all that the processes of a run folder publish, in order."""
    stop = threading.Event()

    def listen() -> None:
        with zmq.Context() as context, context.socket(zmq.SUB) as socket:
            socket.setsockopt(zmq.RCVHWM, 0)
            socket.setsockopt(zmq.RECONNECT_IVL, 20)
            socket.setsockopt(zmq.RECONNECT_IVL_MAX, 100)
            socket.setsockopt(zmq.SUBSCRIBE, b"")
            for process in (*PROCESSES, SUPERVISOR):
                socket.connect(endpoint(run_dir, process))
            while not stop.is_set():
                if socket.poll(50):
                    topic, data = socket.recv_multipart()
                    received.append(Logged(topic.decode(), clock.monotonic_ns(), data))
            socket.close(0)

    thread = threading.Thread(target=listen)
    thread.start()
    try:
        yield
    finally:
        stop.set()
        thread.join()


def nowhere(text: str) -> str:
    """Return a configuration without the paths of the computer that flew it."""
    return text.replace(str(ROOT), "/opt/ods").replace(str(Path.home()), "/home/ods")


def make(name: str) -> None:
    """Fly a mission of the bench, and leave its recording in the tests' data."""
    with tempfile.TemporaryDirectory(prefix="ods-") as place:  # a socket path must be short
        folder, received = Path(place), list[Logged]()
        (folder / "run").mkdir()
        config = bench_config(name, folder)
        with listening(folder / "run", received):
            fly_mission(config)
        text = nowhere((folder / "out" / "onboard.toml").read_text().replace(place, "/tmp/replayed"))
        about = facts(text) | dict.fromkeys(("host", "boot_id", "system"), "")
        offset_ns = int(about["utc_offset_ns"])
        FOLDER.mkdir(parents=True, exist_ok=True)
        path = FOLDER / f"{name}.mcap"
        path.unlink(missing_ok=True)
        segment = Segment(path, offset_ns, {"ods": about})
        segment.enclose("config.toml", "application/toml", text.encode(), offset_ns)
        for message in received:
            segment.write([message._replace(utc_ns=message.utc_ns + offset_ns)])
            if segment.waiting_bytes > 256 * 1024:
                segment.close_chunk()
        segment.finish()
    print(f"{path}: {len(received)} messages, {path.stat().st_size / 1e6:.1f} MB")


if __name__ == "__main__":
    for wanted in sys.argv[1:] or SECONDS:
        make(wanted)
