"""The sonar's message in an entry of a log of ViewPoint, as a ping at the time of its entry."""

from ods.base.clock import NS
from ods.messages import Ping
from ods.sonar_link.files.ping_sequence import recorded_ping
from ods.sonar_link.oculus import image, messages
from ods.sonar_link.oculus.framer import fault_of
from ods.sonar_link.oculus.messages import MessageKind

LATEST_S = 2**33
"""A time, UTC seconds since 1970, is not beyond the year 2242."""


def check(message: bytes) -> None:
    """Raise ValueError for what is no whole message."""
    fault = fault_of(message)
    if fault != "" or messages.unpack_header(message).size > len(message):
        raise ValueError(fault or "truncated")


def is_ping(message: bytes) -> bool:
    """Return whether a message is a simple ping result."""
    return messages.unpack_header(message).kind == MessageKind.PING


def ping_of(message: bytes, time_s: float, index: int) -> Ping:
    """Decode a simple ping result that was logged at a time, UTC. Raises ValueError for numbers that cannot be."""
    if not 0.0 <= time_s < LATEST_S:
        raise ValueError("no time")
    result = messages.decode_ping_result(message, 0)
    frame, geometry = image.amplitudes_of(result, message, 0), image.geometry_of(result, message, 0)
    return recorded_ping(frame, geometry, index, round(time_s * NS), result.ping_number)
