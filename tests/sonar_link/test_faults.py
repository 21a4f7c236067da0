"""Faults of the sonar's line, on the real process: each is survived, counted, and over within 2 s of its cause.

Every test ends with `Sonar.check`: what came out is what was sent, in order, whole, and the counters tell the rest.
"""

import signal
import statistics
import tracemalloc
from collections import Counter
from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import pytest

from ods.base import clock
from ods.runtime.bus import TOPICS
from ods.sonar_link.s7k import records
from ods.sonar_link.s7k.drf import SYNC_WORD, encode_record
from ods.sonar_link.s7k.framer import RecordFramer
from ods.sonar_link.s7k.protocol import S7kProtocol
from ods.sonar_link.settings import SonarSettings
from tests.sonar_link.sonar_process import Process, Sonar, running
from tests.sonar_link.sonar_samples import UTC_NS, Device, make_ping

pytestmark = pytest.mark.slow

RECOVERY_S = 2.0
FULL = {"beams": 60, "samples": 2000, "dr_m": 0.05}
RATE_HZ = 6.7
MS = 1_000_000


@pytest.fixture
def process() -> Iterator[Process]:
    with running() as process:
        yield process


@pytest.fixture
def device(process: Process) -> Iterator[Device]:
    device = Device(process.link)
    yield device
    device.unplug()


@pytest.fixture
def sonar(process: Process, device: Device) -> Iterator[Sonar]:
    sonar = Sonar(process, device)
    yield sonar
    sonar.device.unplug()


# the line itself


def test_unplugged_and_plugged_in_again(process: Process, sonar: Sonar) -> None:
    sonar.device.send(sonar.ping(**FULL)[:50_000])
    sonar.device.unplug()
    process.wait(lambda: process.says("no such file or directory") and process.says("no ping for"))
    assert process.does_not_spin()
    sonar.device = Device(process.link)
    assert sonar.recover() < RECOVERY_S
    process.wait(lambda: not process.problems(), meanwhile=sonar.play)
    assert (process.counter("port_losses"), process.counter("port_opens")) == (1, 2)
    sonar.check()


def test_hung_up_with_its_name_left_behind(process: Process, sonar: Sonar) -> None:
    process.link.unlink()
    process.link.symlink_to("/dev/pts/none")  # another program may get the number of the one that goes
    sonar.device.hang_up()
    process.wait(lambda: process.says("seabat: "))
    assert process.does_not_spin()
    sonar.device = Device(process.link)
    assert sonar.recover() < RECOVERY_S
    sonar.check()


def test_replaced_by_another_device_under_the_same_name(process: Process, sonar: Sonar) -> None:
    old, sonar.device = sonar.device, Device(process.link)
    assert sonar.recover() < RECOVERY_S
    old.offer(records.encode_ping(make_ping(0)))
    sonar.check()  # which would find the old device's ping
    assert (process.counter("port_losses"), process.counter("port_opens")) == (1, 2)
    old.hang_up()


def test_half_open_line(process: Process, sonar: Sonar) -> None:
    """The device is there and silent."""
    assert process.wait(lambda: process.says("no ping for")) < 3.0
    assert process.does_not_spin()
    assert process.problems()[0].startswith("no ping for")
    assert sonar.recover() < RECOVERY_S
    process.wait(lambda: not process.problems(), meanwhile=sonar.play)
    assert process.counter("port_losses") == 0
    sonar.check()


# what comes over it


def test_records_of_which_no_ping_is_made_are_reported_beside_the_silence(process: Process, sonar: Sonar) -> None:
    """A sonar whose sound velocity sensor sends nonsense; that of air would be a ping, which the pipeline refuses."""
    silly = records.encode_ping(make_ping(1, sound_speed=5.0))
    process.wait(
        lambda: (
            process.says("no ping for") and process.says("though other data arrive: ") and process.says("bad_settings")
        ),
        meanwhile=lambda: sonar.device.offer(silly),
    )
    assert sonar.recover() < RECOVERY_S
    process.wait(lambda: not process.problems(), meanwhile=sonar.play)


@pytest.mark.parametrize("cut", [30, 500, 50_000])
def test_writer_stalls_in_mid_frame(process: Process, sonar: Sonar, cut: int) -> None:
    sonar.device.send(sonar.ping(**FULL)[:cut])
    process.wait(lambda: process.counter("truncated_record") == 1)
    sonar.device.send(sonar.ping(**FULL))
    assert process.wait(sonar.last_came) < RECOVERY_S
    sonar.check()
    assert process.counter("lost_pings") == 1


def test_writer_stalls_in_mid_frame_and_goes_on_with_the_next_ping(process: Process, sonar: Sonar) -> None:
    sonar.device.send(sonar.ping(**FULL)[:50_000] + sonar.ping(**FULL))
    assert process.wait(sonar.last_came) < RECOVERY_S
    sonar.check()
    assert process.counter("lost_pings") == 1


def test_writer_that_pauses_in_mid_frame_loses_nothing(process: Process, sonar: Sonar) -> None:
    wire = sonar.ping(**FULL)
    for at in range(0, len(wire), 40_000):
        sonar.device.send(wire[at : at + 40_000])
        process.listen(0.1)
    sonar.check()
    assert process.counter("lost_pings") == 0


def false_header(size: int) -> bytes:
    """A header that is right but for the size that it claims."""
    header = bytearray(encode_record(records.COMPRESSED_WATER_COLUMN, b"", UTC_NS, records.DEVICE)[:64])
    header[8:12] = size.to_bytes(4, "little")
    return bytes(header)


RNG = np.random.default_rng(6)
NOISE = {
    "random": RNG.bytes(5000),
    "sync words": b"".join(RNG.bytes(int(n)) + SYNC_WORD for n in RNG.integers(0, 9, 200)),
    "headers of 4 GB": false_header(2**32 - 1) * 50,
    "headers of 4 MB": false_header(4 * 1024 * 1024) * 50,
    "headers of 60 kB": b"".join(RNG.bytes(20) + false_header(60_000) for _ in range(50)),
    "cut frames": encode_record(records.SONAR_SETTINGS, bytes(156), UTC_NS, records.DEVICE)[:-30] * 20,
    "stuck line": b"\xff" * 3000 + bytes(3000),
}


@pytest.mark.parametrize("noise", NOISE.values(), ids=NOISE.keys())
def test_noise_bursts_between_and_inside_pings(process: Process, sonar: Sonar, noise: bytes) -> None:
    damaged, rng = set(), np.random.default_rng(9)
    for number in range(6):
        wire = sonar.ping()
        if number % 2:
            cut = int(rng.integers(8, len(wire) - 8))
            damaged.add(max(sonar.sent))
            wire = wire[:cut] + noise + wire[cut:]
        sonar.device.send(noise + wire)
    undamaged = sorted(sonar.sent.keys() - damaged)
    assert process.wait(lambda: {ping.ping_number for ping in process.pings} >= set(undamaged)) < RECOVERY_S
    sonar.device.send(noise)
    assert sonar.recover() < RECOVERY_S
    sonar.check()
    # noise between the records of a ping does not damage it
    assert process.counter("lost_pings") <= len(damaged)
    assert process.counter("garbage_bytes") >= 7 * len(noise)


@pytest.mark.parametrize("bit", [16, 17, 19, 21, 22, 31])
def test_a_size_with_one_wrong_bit_holds_nothing_up_for_long(process: Process, sonar: Sonar, bit: int) -> None:
    wire = bytearray(sonar.ping(**FULL))
    at = wire.rindex(SYNC_WORD, 0, 3000) + 4
    wire[at : at + 4] = (int.from_bytes(wire[at : at + 4], "little") ^ 1 << bit).to_bytes(4, "little")
    sonar.device.send(bytes(wire))
    assert sonar.recover() < RECOVERY_S
    sonar.check()


def test_twice_the_sonars_rate(process: Process, sonar: Sonar) -> None:
    for _ in range(60):
        sonar.device.send(sonar.ping(**FULL))
        process.listen(0.5 / RATE_HZ)
    sonar.check()
    assert process.counter("lost_pings") == 0


# back-pressure


def test_a_stopped_process_loses_whole_pings_and_takes_up_the_newest(process: Process, sonar: Sonar) -> None:
    sonar.play_at(RATE_HZ, 1.0, **FULL)
    process.signal(signal.SIGSTOP)
    sonar.play_at(RATE_HZ, 3.0, **FULL)
    process.signal(signal.SIGCONT)
    assert sonar.recover() < RECOVERY_S
    sonar.check()
    assert 15 <= process.counter("lost_pings") <= 21  # one or two may wait in the buffers of the line


def test_a_slow_subscriber_keeps_the_newest_and_counts_the_others(process: Process, sonar: Sonar) -> None:
    for _ in range(100):
        sonar.device.send(sonar.ping(**FULL))
    process.wait(sonar.last_came)
    sonar.check()
    assert process.counter("lost_pings") == 0
    assert process.dropped_here() > 50


def test_a_subscriber_that_is_away_for_long_sees_from_seq_what_it_missed(process: Process, sonar: Sonar) -> None:
    """Beyond ZeroMQ's high-water mark nobody but the sequence tells."""
    sonar.device.send(sonar.ping())
    process.wait(sonar.last_came)
    for _ in range(3000):
        sonar.device.send(sonar.ping())
    process.listen(0.5)
    sonar.device.send(sonar.ping())
    process.wait(sonar.last_came)
    process.hears_again()
    seqs = [ping.seq for ping in process.pings]
    missed = sum(later - earlier - 1 for earlier, later in pairwise(seqs))
    assert len(seqs) + missed == len(sonar.sent) == process.counter("pings") - seqs[0]
    assert process.dropped_here() >= TOPICS["ping"].queue
    assert process.counter("lost_pings") == 0


# clocks


def time_errors_ms(process: Process, sonar: Sonar) -> list[float]:
    return [1e-6 * (ping.t_ns - sonar.sent[ping.ping_number].t_ns) for ping in process.pings]


def play_timed(process: Process, sonar: Sonar, count: int = 20) -> None:
    for _ in range(count):
        sonar.device.send(sonar.ping())
        process.listen(0.05)


@pytest.mark.parametrize("jump_s", [-100, 100])
def test_the_sonars_clock_jumps(process: Process, sonar: Sonar, jump_s: int) -> None:
    """And runs 50 ppm fast."""
    sonar.clock_fast_ppm = 50.0
    play_timed(process, sonar)
    assert process.counter("device_clock_jumps") == 0
    sonar.clock_ahead_ns += jump_s * clock.NS
    play_timed(process, sonar)
    sonar.check()
    assert process.counter("device_clock_jumps") == 1
    errors_ms = time_errors_ms(process, sonar)
    assert statistics.median(map(abs, errors_ms)) < 5.0
    assert max(map(abs, errors_ms)) < 100.0  # the machine may be busy; a jump believed or followed would be 100 s


def test_the_wall_clock_steps(process: Process, sonar: Sonar) -> None:
    play_timed(process, sonar)
    process.signal(signal.SIGUSR1)
    play_timed(process, sonar)
    sonar.check()
    ahead_s = [(ping.utc_ns - clock.utc_ns(ping.t_ns)) / clock.NS for ping in process.pings]
    assert ahead_s[0] == pytest.approx(0.0, abs=1.0)
    assert ahead_s[-1] == pytest.approx(100.0, abs=1.0)
    errors_ms = time_errors_ms(process, sonar)
    assert statistics.median(map(abs, errors_ms)) < 5.0
    assert max(map(abs, errors_ms)) < 100.0
    assert process.counter("device_clock_jumps") == 0


@pytest.mark.parametrize("fast_ppm", [-50.0, 50.0])
def test_a_clock_50_ppm_off_is_followed_for_ten_minutes(fast_ppm: float) -> None:
    """30 ms would come together; no process, as nobody waits so long."""
    late_ns = np.random.default_rng(7).exponential(2 * MS, 4000)
    protocol = S7kProtocol(SonarSettings(port="/dev/seabat"), Counter())
    errors_ms = []
    for number in range(4000):
        transmitted_ns = clock.NS + 150 * MS * number
        ping = make_ping(number, utc_ns=UTC_NS + round(transmitted_ns * (1.0 + 1e-6 * fast_ppm)))
        listened_ns = round(2.0 * (ping.range0_m + (ping.samples - 1) * ping.dr_m) / ping.sound_speed * clock.NS)
        arrival_ns = transmitted_ns + listened_ns + round(late_ns[number])
        (came,) = protocol.feed(records.encode_ping(ping), arrival_ns)
        errors_ms.append(1e-6 * (came.t_ns - transmitted_ns))
    assert max(map(abs, errors_ms[20:])) < 4.0


# changes in mid-stream


def test_range_gain_and_sound_speed_change_from_ping_to_ping(process: Process, sonar: Sonar) -> None:
    rng = np.random.default_rng(8)
    for _ in range(40):
        dr_m = float(rng.choice([0.05, 0.1, 0.25]))
        sonar.device.send(
            sonar.ping(
                beams=int(rng.integers(4, 64)),
                samples=int(rng.integers(20, 2000)),
                dr_m=dr_m,
                range0_m=dr_m * int(rng.integers(0, 30)),
                sound_speed=float(rng.uniform(1420.0, 1560.0)),
                scale_factor=float(rng.choice([20.0, 40.0, 57.0])),
            )
        )
        process.listen(0.02)
    sonar.check()  # compares each ping's geometry with what was sent
    assert process.counter("lost_pings") == 0


# memory


@pytest.mark.parametrize("noise", NOISE.values(), ids=NOISE.keys())
def test_endless_garbage_takes_no_more_memory_than_the_longest_record(noise: bytes) -> None:
    longest = 100_000
    framer = RecordFramer(max_record_bytes=longest)
    chunk = (noise + false_header(longest)) * 3
    tracemalloc.start()
    try:
        for t_ns in range(5 * longest // len(chunk)):
            framer.feed(chunk, t_ns)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    # bytes, their sums of four bytes each, and what growing and cutting a buffer takes for a moment
    assert peak < 3 * 5 * (longest + len(chunk))
