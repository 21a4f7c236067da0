"""`ods record --s7k`: pings, obstacles and poses of a running chain into a file that others' 7k software reads."""

import signal
import threading
from collections import Counter
from collections.abc import Iterator
from contextlib import ExitStack, closing, contextmanager, suppress
from pathlib import Path

import zmq

from ods.base import clock
from ods.base.command_line.terminal import StatusLine
from ods.base.geodesy import LocalFrame
from ods.recording.errors import RecordingError
from ods.recording.s7k import RECORDED_DEVICES, Recorder
from ods.runtime import bus
from ods.sonar_link.files.s7k.writer import S7kWriter

RECORDED_TOPICS = ("ping", "obstacles", "pose")
WRITTEN = ("pings", "contacts", "poses")
"""Counters of what is in the file; the others count losses."""
STATUS_PERIOD_S = 0.25
SYNC_PERIOD_S = 5.0
"""The most that a loss of power takes; a crash of the recorder takes nothing."""
QUEUE = bus.HIGH_WATER_MARK
"""Messages kept of each topic while the disk is slow."""


def record_s7k(path: Path, run_dir: Path, origin_deg: tuple[float, float], seconds: float | None = None) -> None:
    """Record what is published in `run_dir` until SIGINT, SIGTERM or for `seconds`; print a summary.

    origin_deg: latitude and longitude of the local frame's origin.

    Raises RecordingError: the file exists or cannot be written, nothing came.
    """
    frame = LocalFrame(*origin_deg)
    kept = ""
    try:
        with (
            path.open("xb", buffering=0) as file,
            closing(S7kWriter(file, path.name, clock.utc_ns(), RECORDED_DEVICES)) as writer,
        ):
            recorder = Recorder(writer, frame)
            try:
                _follow(recorder, writer, path, run_dir, seconds)
            finally:
                kept = _summary(writer, recorder.counters)
    except FileExistsError:
        raise RecordingError(f"{path}: already exists, and is not overwritten") from None
    except OSError as error:
        raise RecordingError(f"{path}: {error.strerror}" + (f"; kept: {kept}" if kept else "")) from error
    if not any(recorder.counters[what] for what in WRITTEN):
        path.unlink()
        raise RecordingError(
            f"nothing to record was received from {run_dir}: does `ods run` run with this configuration?"
        )
    print(f"{path}: {kept}")


def _follow(recorder: Recorder, writer: S7kWriter, path: Path, run_dir: Path, seconds: float | None) -> None:
    begun = clock.monotonic_ns()
    newest_s = {"ping": begun, "obstacles": begun}
    status_due, sync_due = _Every(STATUS_PERIOD_S, begun), _Every(SYNC_PERIOD_S, begun)
    with ExitStack() as stack:
        stopped = stack.enter_context(_stop_signals())
        context = stack.enter_context(zmq.Context())
        subscriber = stack.enter_context(bus.Subscriber(context, run_dir, RECORDED_TOPICS, queue=QUEUE))
        status = StatusLine()
        stack.callback(status.clear)
        now = begun
        while not stopped.is_set() and (seconds is None or now - begun < seconds * clock.NS):
            received, _ = subscriber.receive(STATUS_PERIOD_S)
            now = clock.monotonic_ns()
            for topic, message in sorted(received, key=lambda item: item[1].t_ns):
                newest_s[topic] = now
                recorder.take(message)
            for subscription in subscriber.subscriptions:
                recorder.counters.update(_unreadable(subscription.counters))
            if sync_due.at(now):
                writer.sync()
            if status_due.at(now):
                status.show(f"{path.name}: {_summary(writer, recorder.counters)}{_silence(newest_s, now)}")


class _Every:
    """Decides when something that is done once a period is due."""

    def __init__(self, period_s: float, begun_ns: int) -> None:
        self._period_ns = round(period_s * clock.NS)
        self._last_ns = begun_ns

    def at(self, now_ns: int) -> bool:
        due = now_ns - self._last_ns >= self._period_ns
        if due:
            self._last_ns = now_ns
        return due


def _unreadable(counters: "Counter[str]") -> dict[str, int]:
    """Return the counts of bad messages and set all to 0; what was dropped shows in the gaps of the sequences."""
    bad = {name: count for name, count in counters.items() if not name.startswith("dropped_")}
    counters.clear()
    return bad


def _silence(newest_s: dict[str, int], now: int) -> str:
    silent = {topic: (now - newest_s[topic]) / clock.NS for topic in ("ping", "obstacles")}
    return "".join(f", no {topic} for {s:.0f} s" for topic, s in silent.items() if s > bus.TOPICS[topic].stale_s)


def _summary(writer: S7kWriter, counters: "Counter[str]") -> str:
    written = [f"{counters[name]} {name}" for name in WRITTEN]
    losses = [f"{name} {count}" for name, count in sorted(counters.items()) if count and name not in WRITTEN]
    return ", ".join([*written, f"{writer.size / 1e6:.1f} MB", *losses])


@contextmanager
def _stop_signals() -> Iterator[threading.Event]:
    """Give an event that the signals to end set, a closed terminal's too; what they did before is put back."""
    stopped = threading.Event()
    before = {number: signal.getsignal(number) for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP)}
    with suppress(ValueError):  # not the main thread: no signals
        for number in before:
            signal.signal(number, lambda *_: stopped.set())
    yield stopped
    with suppress(ValueError):
        for number, handler in before.items():
            signal.signal(number, handler)
