"""Norbit WBMS recordings: the stream of its image port as it comes, such as `nc SONAR 2211 > dive.wbms` writes it."""

from mmap import mmap

from ods.base.clock import NS
from ods.messages import Ping
from ods.sonar_link.files.ping_sequence import recorded_ping
from ods.sonar_link.files.streams.packet_stream import Found, PacketStreamDecoder
from ods.sonar_link.norbit import image, packets
from ods.sonar_link.norbit.framer import fault_of
from ods.sonar_link.norbit.packets import PREAMBLE, SAMPLE_TYPES, PacketKind
from ods.sonar_link.sync_framer import ChecksumBudget

LATEST_S = 2**33
"""A time, UTC seconds since 1970, is not beyond the year 2242."""


class NorbitDecoder(PacketStreamDecoder):
    """A ping's time is that of its transmission by the sonar's clock: UTC where it has a time server."""

    name = "Norbit .wbms"
    signature = ((0, PREAMBLE),)
    suffix = ".wbms"

    sync, image_called, timed = PREAMBLE, "image of a Norbit WBMS", True

    def _look(self, data: mmap, offset: int, budget: ChecksumBudget) -> Found:
        fault = fault_of(data, offset)
        header = packets.unpack_header(data, offset) if fault == "" else None
        if header is None or offset + header.size > len(data) or not _is_sound(data, offset, header, budget):
            return Found(0, corrupt=fault in ("", "bad_ping"))
        return Found(header.size, is_image=header.kind == PacketKind.IMAGE)

    def _ping(self, data: mmap, offset: int, index: int) -> Ping:
        head = packets.decode_image_head(data, offset)
        if head.sample_type not in SAMPLE_TYPES:
            raise ValueError(f"samples of type {head.sample_type}")
        if not 0.0 <= head.time_s < LATEST_S:
            raise ValueError("no time")
        frame, geometry = image.amplitudes_of(head, data, offset), image.geometry_of(head, data, offset)
        return recorded_ping(frame, geometry, index, round(head.time_s * NS), head.ping_number)


def _is_sound(data: mmap, offset: int, header: packets.Header, budget: ChecksumBudget) -> bool:
    allowed = not header.checksum or budget.allows(header.size)
    return allowed and packets.is_sound(memoryview(data)[offset : offset + header.size], header)
