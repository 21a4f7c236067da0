"""Blueprint Oculus recordings (.raw): the sonar's network stream, of which simple ping results are read.

The start time of first-version results has no known unit, so pings come without times.
"""

from mmap import mmap

from ods.messages import Ping
from ods.sonar_link.files.ping_sequence import recorded_ping
from ods.sonar_link.files.streams.packet_stream import Found, PacketStreamDecoder
from ods.sonar_link.oculus import image, messages
from ods.sonar_link.oculus.framer import fault_of
from ods.sonar_link.oculus.messages import CHECK_WORD, MessageKind
from ods.sonar_link.sync_framer import ChecksumBudget


class OculusDecoder(PacketStreamDecoder):
    """Counts `other_messages`, `corrupt_pings` and `garbage_bytes`."""

    name = "Oculus .raw"
    signature = ((0, CHECK_WORD),)
    suffix = ".raw"

    sync, image_called, timed = CHECK_WORD, "simple ping result", False

    def _look(self, data: mmap, offset: int, _budget: ChecksumBudget) -> Found:
        fault = fault_of(data, offset)
        header = messages.unpack_header(data, offset) if fault == "" else None
        if header is None or offset + header.size > len(data):
            return Found(0, corrupt=fault == "bad_ping")
        return Found(header.size, is_image=header.kind == MessageKind.PING)

    def _ping(self, data: mmap, offset: int, index: int) -> Ping:
        result = messages.decode_ping_result(data, offset)
        frame, geometry = image.amplitudes_of(result, data, offset), image.geometry_of(result, data, offset)
        return recorded_ping(frame, geometry, index, ping_number=result.ping_number)
