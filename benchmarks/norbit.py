"""`python -m benchmarks.norbit [--rounds 40]`: what decoding Norbit packets costs, against a memory copy of the same.

Packets of 512 beams of 1000 samples of 16 bits, 1.03 MB: the largest of the maker's document. They come in chunks of
64 kB, as the process reads them. Each part by itself, in turn with the copy, processor time, the median of the rounds.
"""

import argparse
import statistics
import time
import zlib
from collections import Counter
from collections.abc import Callable

import numpy as np

from ods.runtime.port.port import PORT_READ_BYTES
from ods.sim_sonar.device.sonars.norbit_packets import ImageSays, water_column
from ods.sonar_link.norbit.framer import Framer
from ods.sonar_link.norbit.image import amplitudes_of
from ods.sonar_link.norbit.packets import decode_image_head
from ods.sonar_link.norbit.protocol import NorbitProtocol
from ods.sonar_link.settings import SonarSettings

BEAMS, SAMPLES, PACKETS = 512, 1000, 8
SETTINGS = SonarSettings(protocol="norbit", port="tcp://127.0.0.1:2211")


def make_packets() -> list[bytes]:
    """Return packets of noise."""
    rng = np.random.default_rng(0)
    says = ImageSays(
        1500.0, 19531.25, 1.7e9, 1, np.linspace(-1.2, 1.2, BEAMS), 2.4, 400.0, 80.0, 5e-4, 15, 10.0, 0, (0.0, 20.0), 0
    )
    return [
        water_column(says._replace(number=number, time_s=1.7e9 + 0.1 * number), image, 1.0)
        for number, image in enumerate(rng.random((PACKETS, BEAMS, SAMPLES), np.float32), 1)
    ]


def chunks_of(packets: list[bytes]) -> list[bytes]:
    """Return the stream as it is read."""
    stream = b"".join(packets)
    return [stream[at : at + PORT_READ_BYTES] for at in range(0, len(stream), PORT_READ_BYTES)]


def decode(chunks: list[bytes]) -> int:
    """Return how many pings come out."""
    protocol = NorbitProtocol(SETTINGS, Counter())
    return sum(len(protocol.feed(chunk, at)) for at, chunk in enumerate(chunks))


def frame(chunks: list[bytes]) -> int:
    """Return how many packets come out, checksums looked at."""
    framer = Framer()
    return sum(len(framer.feed(chunk)) for chunk in chunks)


def turn(packets: list[bytes]) -> int:
    """Return how many images have been turned to beams of samples."""
    return sum(bool(amplitudes_of(decode_image_head(packet), packet).tobytes()) for packet in packets)


def spent_s(work: Callable[[], object]) -> float:
    """Return the processor time of one call, s."""
    begun = time.process_time()
    work()
    return time.process_time() - begun


def main() -> None:
    """Print all figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--rounds", type=int, default=40, help="of all parts in turn (default: 40)")
    rounds = parser.parse_args().rounds
    packets = make_packets()
    chunks = chunks_of(packets)
    assert decode(chunks) == frame(chunks) == turn(packets) == PACKETS
    parts: dict[str, Callable[[], object]] = {
        "memory copy of the packets": lambda: [bytes(memoryview(packet)) for packet in packets],
        "decoding, from stream to pings": lambda: decode(chunks),
        "  of which finding packets, checksum included": lambda: frame(chunks),
        "    of which the checksum": lambda: [zlib.crc32(memoryview(packet)[24:]) for packet in packets],
        "  of which turning ranges of beams to beams of ranges": lambda: turn(packets),
    }
    times: dict[str, list[float]] = {name: [] for name in parts}
    for _ in range(rounds):
        for name, work in parts.items():
            times[name].append(spent_s(work))
    copy_s = statistics.median(times["memory copy of the packets"])
    size = sum(map(len, packets))
    for name, seconds in times.items():
        median_s = statistics.median(seconds)
        rate = size / 1e6 / median_s
        print(f"{name:54} {1e3 * median_s / PACKETS:6.2f} ms a packet {rate:7.0f} MB/s {median_s / copy_s:6.1f} times")


if __name__ == "__main__":
    main()
