"""`python -m benchmarks.sonar3d15 [--rounds 60]`: what decoding packets of a Sonar 3D-15 costs.

The 6 range images of tests/data/sonar3d15, as datagrams: against a memory copy of them, a copy of the images that they
hold, and, where it is installed (the extra `peers`), Water Linked's own client, up to an array of ranges as ours.
Each in turn, processor time, the median of the rounds. And what the chain takes for the same images.
"""

import argparse
import statistics
import time
import zlib
from collections import Counter
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from ods.pipeline.chain import Chain
from ods.pipeline.settings import PipelineSettings
from ods.sonar_link.files.opening import open_pings
from ods.sonar_link.settings import SonarSettings
from ods.sonar_link.sonar3d15 import packets
from ods.sonar_link.sonar3d15.protocol import Sonar3d15Protocol
from ods.sonar_link.sonar3d15.unpack import pixels_of, snappy_block

RECORDING = Path(__file__).parents[1] / "tests" / "data" / "sonar3d15" / "ship_short.sonar"
SETTINGS = SonarSettings(protocol="sonar3d15", port="udp://224.0.0.96:4747")


def datagrams() -> list[bytes]:
    """Return the packets of range images."""
    stream, at, found = RECORDING.read_bytes(), 0, []
    while at < len(stream):
        packet = stream[at : at + packets.size_of(stream, at)]
        at += len(packet)
        if packets.unpack(packet).kind == packets.RANGE_IMAGE:
            found.append(packet)
    return found


def decode(found: list[bytes]) -> int:
    """Return how many pings come out."""
    protocol = Sonar3d15Protocol(SETTINGS, Counter())
    return sum(len(protocol.feed(packet, at)) for at, packet in enumerate(found))


def decode_by_wlsonar(found: list[bytes]) -> int:
    """Return how many arrays of ranges come out of Water Linked's client."""
    from wlsonar.range_image_protocol import unpackb  # type: ignore[import-not-found, import-untyped, unused-ignore]

    images = [unpackb(packet) for packet in found]
    return sum(np.array(each.image_pixel_data, np.uint16).reshape(each.height, -1).size > 0 for each in images)


def spent_s(work: Callable[[], object]) -> float:
    """Return the processor time of one call, s."""
    begun = time.process_time()
    work()
    return time.process_time() - begun


def parts_of(found: list[bytes]) -> dict[str, Callable[[], object]]:
    """Return what is timed, by name; the first is what all else is compared with."""
    blocks = [packet[packets.HEAD_BYTES : -packets.CHECKSUM_BYTES] for packet in found]
    packed = [packets.decode_range_image(packets.unpack(packet).message).packed for packet in found]
    images = [pixels_of(numbers, 256, 64) for numbers in packed]
    pings, chain = [*open_pings(RECORDING).pings], Chain(PipelineSettings())
    parts: dict[str, Callable[[], object]] = {
        "memory copy of the packets": lambda: [bytes(memoryview(packet)) for packet in found],
        "memory copy of the images": lambda: [image.copy() for image in images],
        "decoding, from datagrams to pings": lambda: decode(found),
        "  of which the checksum": lambda: [zlib.crc32(packet) for packet in found],
        "  of which Snappy": lambda: [snappy_block(block, packets.MAX_MESSAGE_BYTES) for block in blocks],
        "  of which the numbers": lambda: [pixels_of(numbers, 256, 64) for numbers in packed],
        "the chain, from pings to detections": lambda: [chain.process(ping) for ping in pings],
    }
    if find_spec("wlsonar"):
        parts["wlsonar, from datagrams to arrays"] = lambda: decode_by_wlsonar(found)
    return parts


def main() -> None:
    """Print all figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--rounds", type=int, default=60, help="of all parts in turn (default: 60)")
    rounds = parser.parse_args().rounds
    found = datagrams()
    assert decode(found) == len(found) == 6
    parts = parts_of(found)
    times: dict[str, list[float]] = {name: [] for name in parts}
    for _ in range(rounds):
        for name, work in parts.items():
            times[name].append(spent_s(work))
    medians = {name: statistics.median(seconds) / len(found) for name, seconds in times.items()}
    copy_s = next(iter(medians.values()))
    for name, median_s in medians.items():
        print(f"{name:40} {1e6 * median_s:9.1f} us an image {median_s / copy_s:9.1f} times")


if __name__ == "__main__":
    main()
