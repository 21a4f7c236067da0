"""`benchmarks.processes.sonar_link [--seconds 600]`: the sonar process on a full 12 Mbaud line, and the decoder alone.

The real process reads a pseudo-terminal. A pseudo-terminal has no baud rate, so the writer paces: each millisecond the
bytes that a UART would have sent by then. It holds what the pseudo-terminal (12 kB) does not take, as the buffer of a
serial driver does.
"""

import argparse
import subprocess
import sys
import tempfile
import threading
import time
import tomllib
from dataclasses import dataclass, field
from pathlib import Path

import msgspec
import numpy as np
import psutil
import tomli_w
import zmq

from ods.base import clock
from ods.messages import Health, Ping
from ods.runtime.bus import Subscriber
from ods.sim_sonar.device.lines.serial_line import SerialLine
from ods.sonar_link.s7k import records
from ods.sonar_link.s7k.assembler import Assembler
from ods.sonar_link.s7k.framer import RecordFramer

CONFIG = Path("config/onboard.toml")
BYTES_A_SECOND = 1_200_000
"""12 Mbaud, 8N1."""
STEP_S = 0.001
DRIVER_BUFFER_S = 0.5
"""What a serial driver holds (640 kB) before it loses bytes."""
SETTLING_S = 2.0
SILENCE_S = 2.0
BEAMS, SAMPLES = 60, 2000
PINGS_DECODED = 200
CHUNKS = (1200, 4096, 65536)


def make_pings(count: int) -> list[Ping]:
    """Return some pings of 8-bit noise to send in turn."""
    rng = np.random.default_rng(0)
    bearing_rad = np.radians(np.linspace(-44.25, 44.25, BEAMS)).tolist()
    return [
        Ping(
            seq=0, ping_number=0, t_ns=0, t_rx_ns=0, utc_ns=0, beams=BEAMS, samples=SAMPLES, dtype="u1",
            data=rng.integers(0, 200, (BEAMS, SAMPLES), np.uint8).tobytes(), bearing_rad=bearing_rad, range0_m=0.0,
            dr_m=0.05, sound_speed=1500.0, scale="log8", scale_factor=40.0,
        )
        for _ in range(count)
    ]  # fmt: skip


def wire_of(ping: Ping, number: int) -> bytes:
    """Return the records of a ping that leaves the sonar now."""
    return records.encode_ping(msgspec.structs.replace(ping, ping_number=number, utc_ns=clock.utc_ns()))


class Uart(threading.Thread):
    """Plays pings without a gap at the line's rate."""

    def __init__(self, line: SerialLine) -> None:
        super().__init__(daemon=True)
        self.sent_ns: list[int] = []
        """When the last byte of each ping was through on a line that never waits."""
        self.longest_wait_s = 0.0
        """How far the reader was behind the line at worst."""
        self.stopping = False
        self._line = line

    def run(self) -> None:
        """Send until `stopping`; end with a whole ping."""
        pings = make_pings(8)
        start_ns, total = clock.monotonic_ns(), 0
        while not self.stopping:
            wire = wire_of(pings[len(self.sent_ns) % len(pings)], len(self.sent_ns))
            sent = 0
            while sent < len(wire):
                due = (clock.monotonic_ns() - start_ns) * BYTES_A_SECOND // clock.NS - total
                if due > sent:
                    self._line.write([wire[sent:due]], DRIVER_BUFFER_S)
                    sent = min(due, len(wire))
                    behind_s = (clock.monotonic_ns() - start_ns) / clock.NS - (total + sent) / BYTES_A_SECOND
                    self.longest_wait_s = max(self.longest_wait_s, behind_s)
                time.sleep(STEP_S)
            total += len(wire)
            self.sent_ns.append(start_ns + total * clock.NS // BYTES_A_SECOND)


@dataclass
class Received:
    """What came out at the subscriber."""

    arrived_ns: dict[int, int] = field(default_factory=dict)
    """By ping number."""
    health: Health | None = None

    def take(self, subscriber: Subscriber, timeout_s: float) -> None:
        """Take what comes within the time."""
        messages, _ = subscriber.receive(timeout_s)
        now = clock.monotonic_ns()
        for topic, message in messages:
            if topic == "ping":
                self.arrived_ns[message.ping_number] = now
            else:
                self.health = message


@dataclass(frozen=True)
class Usage:
    """What the process had used by now."""

    user_s: float
    system_s: float
    wakes: int
    rss_mb: float

    @classmethod
    def of(cls, process: psutil.Process) -> "Usage":
        """Look at a process."""
        used = process.cpu_times()
        return cls(used.user, used.system, process.num_ctx_switches().voluntary, process.memory_info().rss / 1e6)


def run_process(seconds: float) -> None:
    """Run the sonar process on a full line for so long; print what came out and what it cost."""
    with tempfile.TemporaryDirectory(prefix="ods") as folder:
        line = SerialLine(Path(folder) / "seabat")
        config = _write_config(Path(folder), Path(folder) / "seabat")
        process = subprocess.Popen([sys.executable, "-m", "ods", "sonar", "--log-level", "warning", "--config", config])
        context: zmq.Context[zmq.Socket[bytes]] = zmq.Context()
        try:
            with Subscriber(context, Path(folder), ["ping"], ["sonar"]) as subscriber:
                _measure(subscriber, Uart(line), psutil.Process(process.pid), seconds)
        finally:
            process.terminate()
            process.wait()
            context.term()
            line.unplug()


def _write_config(folder: Path, port: Path) -> Path:
    settings = tomllib.loads(CONFIG.read_text())
    settings["bus"]["run_dir"] = str(folder)
    settings["sonar"]["port"] = str(port)
    path = folder / "onboard.toml"
    path.write_text(tomli_w.dumps(settings))
    return path


def _measure(subscriber: Subscriber, uart: Uart, process: psutil.Process, seconds: float) -> None:
    received = Received()
    while received.health is None or not received.health.ready:
        received.take(subscriber, 0.1)
    uart.start()
    _listen(subscriber, received, SETTLING_S)
    before, since_s = Usage.of(process), time.monotonic()
    _listen(subscriber, received, seconds / 2)
    halfway = Usage.of(process)
    _listen(subscriber, received, seconds / 2)
    after, elapsed_s = Usage.of(process), time.monotonic() - since_s
    uart.stopping = True
    uart.join()
    _listen(subscriber, received, SILENCE_S)

    sent = len(uart.sent_ns)
    latency_ms = [1e-6 * (received.arrived_ns[n] - uart.sent_ns[n]) for n in sorted(received.arrived_ns)]
    p50, p99, worst = np.percentile(latency_ms, [50, 99, 100])
    user_s, system_s = after.user_s - before.user_s, after.system_s - before.system_s
    print(f"pings: {sent} sent, {len(received.arrived_ns)} received, {sent - len(received.arrived_ns)} lost")
    print(f"counters: {dict(sorted(received.health.counters.items()))}")
    print(f"CPU: {100 * (user_s + system_s) / elapsed_s:.1f} % of a core ({user_s:.1f} s user, {system_s:.1f} s system "
          f"in {elapsed_s:.0f} s), {(after.wakes - before.wakes) / elapsed_s:.0f} wakes/s")  # fmt: skip
    print(f"latency, last byte to subscriber: p50 {p50:.1f} ms, p99 {p99:.1f} ms, worst {worst:.1f} ms; "
          f"reader behind the line by {1e3 * uart.longest_wait_s:.1f} ms at worst")  # fmt: skip
    print(f"memory: {after.rss_mb:.1f} MB, grown by {halfway.rss_mb - before.rss_mb:.2f} MB in the first half, "
          f"by {after.rss_mb - halfway.rss_mb:.2f} MB in the second")  # fmt: skip


def _listen(subscriber: Subscriber, received: Received, seconds: float) -> None:
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        received.take(subscriber, 0.1)


def run_decoder() -> None:
    """Print the throughput of framer and assembler alone, by the size of the chunks."""
    wire = b"".join(wire_of(ping, number) for number, ping in enumerate(make_pings(8) * (PINGS_DECODED // 8)))
    for size in CHUNKS:
        framer, assembler = RecordFramer(), Assembler()
        start = time.process_time()
        for at in range(0, len(wire), size):
            for record in framer.feed(wire[at : at + size], at):
                assembler.feed(record, records.decode(record))
        spent_s = time.process_time() - start
        assert assembler.counters["pings"] == PINGS_DECODED
        print(f"framer and assembler alone, chunks of {size} bytes: {len(wire) / 1e6 / spent_s:.0f} MB/s")


def main() -> None:
    """Print all figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--seconds", type=float, default=600.0, help="length of the run (default: 600)")
    args = parser.parse_args()
    run_decoder()
    run_process(args.seconds)


if __name__ == "__main__":
    main()
