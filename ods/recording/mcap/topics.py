"""Possible contents of a recording: the topics of the bus, and their message types."""

import msgspec

from ods.messages import Health
from ods.runtime import bus

MESSAGES: dict[str, type[msgspec.Struct]] = {
    **{topic.name: topic.message for topic in bus.TOPICS.values()},
    bus.HEALTH: Health,
}
"""By topic; `health` is that of all processes."""
_DECODERS = {topic: msgspec.msgpack.Decoder(kind) for topic, kind in MESSAGES.items()}


class Stamp(msgspec.Struct):
    """What most messages have in common."""

    seq: int | None = None
    t_ns: int | None = None


_STAMPS = msgspec.msgpack.Decoder(Stamp)


def decoded(topic: str, data: bytes) -> msgspec.Struct:
    """Return a message of the bus, types and bounds checked. Raises ValueError, of which msgspec's errors are some."""
    if topic not in _DECODERS:
        raise ValueError(f"not a topic of this version: {topic!r}")
    try:
        return _DECODERS[topic].decode(data)
    except RecursionError as error:
        raise ValueError("nested too deep") from error


def stamp_of(data: bytes) -> Stamp | None:
    """Return the stamp of a message of any topic; None: it is no message."""
    try:
        return _STAMPS.decode(data)
    except bus.UNDECODABLE:
        return None


class _Sender(msgspec.Struct):
    process: str = ""
    pid: int = 0
    rss_mb: float = 0.0


_SENDERS = msgspec.msgpack.Decoder(_Sender)


def process_of(health: bytes) -> tuple[str, int]:
    """Return the process that reports its own health, and its id; ("", 0): not health, or reported by `ods run`."""
    try:
        sender = _SENDERS.decode(health)
    except bus.UNDECODABLE:
        return "", 0
    return (sender.process, sender.pid) if sender.rss_mb > 0.0 else ("", 0)
