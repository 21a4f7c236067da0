"""`ods record` as a process on real sockets: bytes as on the wire, kill -9, full and stalled disks."""

import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import msgspec
import pytest
import zmq

from ods.base import clock
from ods.messages import Health, SonarAnswer, SonarRequest
from ods.recording.mcap.reader import Recorded, open_recording
from ods.runtime import bus
from tests.recording.mcap_samples import Sample, mission, pose, small_ping, write_segment

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
PINGS, POSES = 69, 1035
PATIENCE_S = 30.0


class Live:
    """The publishers of a chain, and a recorder of it."""

    def __init__(self, folder: Path, record: str = "") -> None:
        self.run_dir, self.out = folder / "run", folder / "out"
        self.run_dir.mkdir()
        self.config = folder / "onboard.toml"
        text = (ROOT / "config" / "onboard.toml").read_text()
        text = text.replace("[bus]", f'[bus]\nrun_dir = "{self.run_dir}"')
        text = text.replace('folder = "~/.local/state/ods/recordings"', f'folder = "{self.out}"\n{record}')
        self.config.write_text(text)
        self._context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        self._publishers = {
            name: bus.Publisher(self._context, self.run_dir, name) for name in ("sonar", "nav", "pipeline", "tracker")
        }
        self._health = bus.Subscriber(self._context, self.run_dir, [], ["record"])
        self.health: Health | None = None
        self.process: subprocess.Popen[str]

    def record(self, *arguments: str, prelude: str = "", environment: Mapping[str, str] | None = None) -> None:
        """Start a recorder and wait until it receives everybody."""
        program = f"{prelude}\nimport sys\nfrom ods.cli import main\nsys.exit(main(sys.argv[1:]))"
        command = [sys.executable, "-c", program, "record", *arguments, "--config", str(self.config)]
        self.process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=ROOT,
            env=os.environ | (environment or {}),
        )  # fmt: skip
        self.until(lambda: self.health is not None and self.health.pid == self.process.pid)

        def received() -> bool:
            for topic in ("pose", "ping", "detections", "obstacles", "sonar-requests"):
                self.publish(topic, pose(0, 0))  # of the wrong type, but the recorder does not mind
            assert self.health is not None
            rates = self.health.rates_hz
            return all(rates[topic] for topic in ("pose", "ping", "detections", "obstacles", "sonar-requests"))

        self.until(received)

    def publish(self, topic: str, message: msgspec.Struct) -> None:
        self._publishers[bus.TOPICS[topic].publisher].publish(topic, message)

    def play(self, samples: list[Sample], pause_s: float = 0.0) -> None:
        """Publish messages, waiting after each ping."""
        for topic, _, message in samples:
            self.publish(topic, message)
            if topic == "obstacles":
                time.sleep(pause_s)

    def until(self, wanted: Callable[[], bool]) -> None:
        deadline = time.monotonic() + PATIENCE_S
        while not wanted():
            assert self.process.poll() is None, self.process.communicate()
            assert time.monotonic() < deadline, self.health
            for _, message in self._health.receive(0.02)[0]:
                self.health = message

    def says(self, text: str) -> bool:
        return self.health is not None and any(text in problem for problem in self.health.problems)

    def count(self, name: str) -> int:
        return 0 if self.health is None else self.health.counters.get(name, 0)

    def close(self) -> None:
        self.process.kill()
        self.process.communicate()
        for publisher in self._publishers.values():
            publisher.close()
        self._health.close()
        self._context.term()


@contextmanager
def live(record: str = "") -> Iterator[Live]:
    with tempfile.TemporaryDirectory(prefix="ods-") as folder:  # a socket path must be short
        made = Live(Path(folder), record)
        try:
            yield made
        finally:
            made.close()


def _wire(samples: list[Sample]) -> dict[str, list[bytes]]:
    found: dict[str, list[bytes]] = {}
    for topic, _, message in samples:
        found.setdefault(topic, []).append(msgspec.msgpack.encode(message))
    return found


def _kept(folder: Path, samples: list[Sample]) -> dict[str, list[bytes]]:
    """Return what was recorded of samples, by topic, without what came before them."""
    wanted = {body for bodies in _wire(samples).values() for body in bodies}
    found: dict[str, list[bytes]] = {}
    for each in open_recording(folder).messages():
        if each.data in wanted:
            found.setdefault(each.topic, []).append(each.data)
    return found


def _of(folder: Path, topic: str) -> list[Recorded]:
    return list(open_recording(folder).messages([topic]))


def test_everything_is_recorded_as_it_was_on_the_wire() -> None:
    samples = mission(20)
    asked, answered = SonarRequest(range_m=50.0), SonarAnswer(ok=True, reason="", range_m=50.0)
    samples += [("sonar-requests", 0, asked), ("sonar-answers", 0, answered)]
    with live() as chain:
        chain.record("--out", str(chain.out))
        before = clock.monotonic_ns()
        chain.play(samples, 0.01)
        chain.until(lambda: _kept(chain.out, samples).get("sonar-answers") is not None)
        after = clock.monotonic_ns()
        finish = [sys.executable, "-m", "ods", "record", "--finish", str(chain.out)]
        assert "is being written" in subprocess.run(finish, capture_output=True, text=True, check=False).stderr
        chain.process.send_signal(signal.SIGTERM)
        assert chain.process.wait(10) == 0
        assert _kept(chain.out, samples) == _wire(samples)
        recording = open_recording(chain.out)
        read = list(recording.messages())
        assert [each.log_ns for each in read] == sorted(each.log_ns for each in read)
        last = [each for each in read if each.topic == "ping"][-1]
        assert before < last.log_ns < after
        assert abs(last.utc_ns - clock.utc_ns(last.log_ns)) < clock.NS
        said = [each.message() for each in recording.messages(["health"])]
        assert {each.process for each in said if isinstance(each, Health)} == {"record"}
        facts = recording.metadata["ods"]
        assert facts["version"]
        assert facts["cpu_flags"]
        assert facts["numpy"]
        assert recording.attachments["config.toml"] == chain.config.read_bytes()
        assert f"process record {chain.process.pid}" in recording.metadata
        assert recording.losses == {}
        assert chain.health is not None
        assert chain.count("dropped_messages") == 0


@pytest.mark.parametrize("when", ["at once", "in the middle"])
def test_kill_9_loses_nothing_that_had_reached_the_recorder(when: str) -> None:
    """The model: 69 pings of 120 kB and 1035 poses; the poses behind the last ping are kept, too."""
    samples = mission(PINGS, POSES // PINGS, samples=40_000)
    samples = [*samples[:-1], ("pose", 0, pose(POSES, 5)), samples[-1]]
    with live() as chain:
        chain.record("--out", str(chain.out))
        chain.play(samples, 0.02)
        last = msgspec.msgpack.encode(samples[-1][2])
        if when == "at once":
            chain.until(lambda: any(each.data == last for each in _of(chain.out, "obstacles")))
        else:
            time.sleep(0.05)
        chain.process.kill()
        chain.process.wait()
        kept = _kept(chain.out, samples)
        print({topic: len(bodies) for topic, bodies in kept.items()})
        assert kept == _wire(samples)
        assert open_recording(chain.out).losses == {}

        finished = subprocess.run(
            [sys.executable, "-m", "ods", "record", "--finish", str(chain.out)],
            capture_output=True, text=True, cwd=ROOT, check=True,
        )  # fmt: skip
        assert "complete" in finished.stdout
        assert _kept(chain.out, samples) == _wire(samples)
        again = [sys.executable, "-m", "ods", "record", "--finish", str(next(chain.out.glob("*.mcap")))]
        assert "is complete" in subprocess.run(again, capture_output=True, text=True, cwd=ROOT, check=True).stdout


def test_a_restarted_recorder_goes_on_beside_the_segment_of_the_killed_one() -> None:
    samples = mission(8, 3)
    with live("segment_min = 0.1") as chain:
        chain.record()
        chain.play(samples[:24], 0.01)
        chain.until(lambda: bool(_kept(chain.out, samples[23:24])))
        chain.process.kill()
        chain.process.communicate()
        chain.health = None
        chain.record()
        chain.play(samples[24:], 0.01)
        chain.until(lambda: bool(_kept(chain.out, samples[-1:])))
        chain.process.terminate()
        assert chain.process.wait(10) == 0
        (folder,) = chain.out.iterdir()
        assert [path.name for path in sorted(folder.iterdir())] == ["00000.mcap", "00001.mcap"]
        assert _kept(chain.out, samples) == _wire(samples)
        chain.process.communicate()
        chain.health = None
        chain.record()  # a clean end: the next one is another recording
        chain.until(lambda: len(list(chain.out.iterdir())) == 2)


FULL = """
import os, time
real, disk = os.pwrite, os.environ["DISK"]
def pwrite(fd, data, place):
    if not os.readlink(f"/proc/self/fd/{fd}").endswith(".mcap"):
        return real(fd, data, place)
    while os.path.exists(disk + ".stalled"):
        time.sleep(0.01)
    if os.path.exists(disk + ".broken"):
        raise OSError(30, "Read-only file system")
    if not os.path.exists(disk + ".full"):
        return real(fd, data, place)
    if len(data) > 200:
        return real(fd, data[: len(data) // 2], place)
    raise OSError(28, "No space left on device")
os.pwrite = pwrite
"""
"""A disk that is full takes half of a write first, as real ones do."""


def test_a_full_disk_is_reported_and_recording_goes_on_when_there_is_room() -> None:
    samples = mission(30, 5)
    third = len(samples) // 3
    with live() as chain:
        disk = chain.run_dir / "disk"
        chain.record("--out", str(chain.out), prelude=FULL, environment={"DISK": str(disk)})
        chain.play(samples[:third], 0.01)
        chain.until(lambda: bool(_kept(chain.out, samples[third - 1 : third])))
        Path(f"{disk}.full").touch()
        chain.play(samples[third : 2 * third], 0.01)
        chain.until(lambda: chain.says("no space left on device: not recorded"))
        whole = open_recording(chain.out)
        kept = _kept(chain.out, samples)
        assert all(kept[topic] == bodies[: len(kept[topic])] for topic, bodies in _wire(samples).items())
        assert sum(1 for _ in whole.messages()) > 0
        assert whole.losses == {}
        Path(f"{disk}.full").unlink()
        chain.until(lambda: chain.health is not None and not chain.health.problems)
        chain.play(samples[2 * third :], 0.01)
        chain.until(lambda: bool(_kept(chain.out, samples[-1:])))
        assert _kept(chain.out, samples) == _wire(samples)
        assert chain.count("dropped_messages") == 0


@pytest.mark.parametrize("fault", ["full", "broken"])
def test_a_recording_that_breaks_off_does_not_end_well(fault: str) -> None:
    """The kernel makes the file system of a failing disk read-only: the end said that recording goes on."""
    samples = mission(10)
    with live() as chain:
        disk = chain.run_dir / "disk"
        chain.record("--out", str(chain.out), prelude=FULL, environment={"DISK": str(disk)})
        chain.play(samples, 0.01)
        chain.until(lambda: bool(_kept(chain.out, samples[-1:])))
        Path(f"{disk}.{fault}").touch()
        chain.play(mission(20)[len(samples) :], 0.01)
        chain.until(lambda: chain.says("not recorded"))
        chain.process.terminate()
        said = chain.process.communicate(timeout=10)[1]
        assert chain.process.returncode == 2
        assert "messages lost" in said.splitlines()[-1]
        assert "goes on" not in said


@pytest.mark.parametrize("moved", [True, False], ids=["moved", "removed"])
@pytest.mark.parametrize("named", [True, False], ids=["--out", "record.folder"])
def test_a_folder_that_is_gone_is_made_anew_and_recording_goes_on(named: bool, moved: bool) -> None:
    """Somebody tidies up, or takes the disk away: nothing was recorded from then on, until the recorder's end."""
    samples = mission(10)
    with live() as chain:
        chain.record(*(["--out", str(chain.out)] if named else []))
        chain.play(samples, pause_s=0.02)
        chain.until(lambda: bool(list(chain.out.rglob("*.mcap"))))
        chain.out.rename(chain.out.with_name("elsewhere"))
        if not moved:
            shutil.rmtree(chain.out.with_name("elsewhere"))
        chain.play(samples, pause_s=0.05)
        chain.until(lambda: bool(list(chain.out.rglob("*.mcap"))))
        chain.play(samples, pause_s=0.02)
        chain.process.send_signal(signal.SIGTERM)
        assert chain.process.wait(10) == 0
        (path,) = chain.out.rglob("*.mcap")
        pings = [each for each in open_recording(path).messages() if each.topic == "ping"]
        assert len(pings) >= 10
        assert open_recording(path).attachments
        if moved:
            (left,) = chain.out.with_name("elsewhere").rglob("*.mcap")
            assert any(each.topic == "ping" for each in open_recording(left).messages())


def test_a_disk_that_stalls_holds_up_nobody() -> None:
    """What does not fit the queue is dropped and reported; health goes on, and so does the end."""
    with live("queue_mb = 1") as chain:
        disk = chain.run_dir / "disk"
        chain.record("--out", str(chain.out), prelude=FULL, environment={"DISK": str(disk)})
        Path(f"{disk}.stalled").touch()
        for number in range(30):
            chain.publish("ping", small_ping(number, number, samples=40_000))
            time.sleep(0.01)
        chain.until(lambda: chain.says("the disk has not responded") and chain.says("messages lost"))
        assert chain.count("dropped_messages") > 15
        begun = time.monotonic()
        chain.process.terminate()
        assert chain.process.wait(10) == 0
        assert time.monotonic() - begun < 5.0


def test_rules_for_a_full_disk() -> None:
    """Delete the oldest: by a bound on free room that no disk keeps; the newest of three recordings stays."""
    with live(f'when_full = "delete_oldest"\nkeep_free_mb = {10**9}') as chain:
        for name in ("a", "b"):
            (chain.out / name).mkdir(parents=True)
            write_segment(chain.out / name / "00000.mcap", mission(1))
        chain.record()
        chain.until(lambda: chain.count("deleted_segments") == 2 and chain.says("no space left"))
    with live(f'when_full = "stop"\nkeep_free_mb = {10**9}') as chain:
        chain.record()
        chain.until(lambda: chain.says("stopped until restart"))


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--out", "/proc/nowhere"], "/proc/nowhere"),
        (["--config", "config/onboard-nmea.toml"], "record.folder: missing"),
        (["--out", "{full}"], "already contains a recording"),
    ],
)
def test_what_cannot_be_is_one_line(tmp_path: Path, arguments: list[str], says: str) -> None:
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "00000.mcap").touch()
    arguments = [word.format(full=tmp_path / "full") for word in arguments]
    command = [sys.executable, "-m", "ods", "record", "--config", "config/onboard.toml", *arguments]
    if says.startswith("/proc"):
        command += ["--seconds", "1"]
    done = subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False, timeout=60)
    assert says in done.stderr
    assert "Traceback" not in done.stderr
    assert done.returncode == 2  # a script that starts it must know that there is no recording
