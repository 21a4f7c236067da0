"""Recordings of a Sonar 3D-15: its packets as they come, such as its own interface and `wlsonar` write them."""

from mmap import mmap

from ods.messages import Ping
from ods.sonar_link.files.streams.packet_stream import Found, PacketStreamDecoder
from ods.sonar_link.ping_builder import Stamp
from ods.sonar_link.sonar3d15 import packets
from ods.sonar_link.sonar3d15.image import LATEST_NS, ping_of
from ods.sonar_link.sonar3d15.packets import RANGE_IMAGE, SYNC
from ods.sonar_link.sync_framer import ChecksumBudget


class Sonar3d15Decoder(PacketStreamDecoder):
    """A ping's time is the sonar's own, UTC where it has a time server."""

    name = "Water Linked .sonar"
    signature = ((0, SYNC),)
    suffix = ".sonar"

    sync, image_called, timed = SYNC, "range image of a Sonar 3D-15", True

    def _look(self, data: mmap, offset: int, budget: ChecksumBudget) -> Found:
        if packets.fault_of(data, offset) != "":
            return Found(0)
        size = packets.size_of(data, offset)
        if offset + size > len(data) or not budget.allows(size):
            return Found(0, corrupt=True)
        packet = data[offset : offset + size]
        if not packets.is_sound(packet):
            return Found(0, corrupt=True)
        try:
            kind = packets.unpack(packet).kind
        except ValueError:
            return Found(0, corrupt=True)
        return Found(size, is_image=kind == RANGE_IMAGE)

    def _ping(self, data: mmap, offset: int, index: int) -> Ping:
        packet = data[offset : offset + packets.size_of(data, offset)]
        image = packets.decode_range_image(packets.unpack(packet).message)
        if not 0 <= image.time_ns < LATEST_NS:
            raise ValueError("no time")
        return ping_of(image, Stamp(index, image.number, image.time_ns, image.time_ns, image.time_ns))
