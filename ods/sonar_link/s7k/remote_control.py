"""Remote control of a sonar: request 7500, acknowledgement 7501, refusal 7502. Pure codec, both ways.

The definition of the commands could not be had; what is here was read from public clients of the 7k center, which agree
where they overlap: MB-System (request header, replies, 1051) and the University of New Hampshire's 7P client, the only
one to show range, power and gain, each with one float32. The error codes of refusals are not known.
"""

import math
import struct
from collections.abc import Iterable
from dataclasses import dataclass

from ods.sonar_link.s7k.drf import DeviceId, S7kRecord, encode_record
from ods.sonar_link.s7k.loss import Loss, RecordError

REMOTE_CONTROL = 7500
ACKNOWLEDGED = 7501
REFUSED = 7502

SET_RANGE = 1003
"""m."""
SET_POWER = 1005
"""dB re 1 uPa at 1 m."""
SET_GAIN = 1008
"""dB."""
SUBSCRIBE = 1051
"""Over the same connection, to a list of record types."""

_REQUEST = struct.Struct("<II16s")
_REPLY = struct.Struct("<I16s")
_ERROR = struct.Struct("<I")
_VALUE = struct.Struct("<f")
_COUNT = struct.Struct("<I")
MAX_SUBSCRIBED = 256


@dataclass(frozen=True)
class ControlRequest:
    """One command."""

    command: int
    ticket: int
    """Chosen by who asks, repeated in the reply."""
    parameters: bytes = b""
    tracking: bytes = bytes(16)


@dataclass(frozen=True)
class ControlReply:
    """What became of a request."""

    ticket: int
    error: int | None
    """None: acknowledged; else why it was refused."""


def set_value(command: int, ticket: int, value: float) -> ControlRequest:
    """Return the request that sets range, power or gain."""
    return ControlRequest(command, ticket, _VALUE.pack(value))


def value_of(request: ControlRequest) -> float:
    """Return what range, power or gain is to be set to. Raises RecordError."""
    if len(request.parameters) < _VALUE.size:
        raise RecordError(Loss.BAD_REMOTE_CONTROL)
    value = float(_VALUE.unpack_from(request.parameters)[0])
    if not math.isfinite(value):
        raise RecordError(Loss.BAD_REMOTE_CONTROL)
    return value


def subscribe(ticket: int, record_types: Iterable[int]) -> ControlRequest:
    """Return the request for these record types, from now on, over the connection that it is sent on."""
    types = list(record_types)
    return ControlRequest(SUBSCRIBE, ticket, struct.pack(f"<I{len(types)}I", len(types), *types))


def subscribed_types(request: ControlRequest) -> set[int]:
    """Return the record types of a subscription. Raises RecordError."""
    if len(request.parameters) < _COUNT.size:
        raise RecordError(Loss.BAD_REMOTE_CONTROL)
    (count,) = _COUNT.unpack_from(request.parameters)
    if count > MAX_SUBSCRIBED or len(request.parameters) < _COUNT.size * (1 + count):
        raise RecordError(Loss.BAD_REMOTE_CONTROL)
    return set(struct.unpack_from(f"<{count}I", request.parameters, _COUNT.size))


def encode_request(request: ControlRequest, utc_ns: int, device: DeviceId) -> bytes:
    """Return record 7500, framed, to the sonar `device`."""
    body = _REQUEST.pack(request.command, request.ticket, request.tracking) + request.parameters
    return encode_record(REMOTE_CONTROL, body, utc_ns, device)


def decode_request(record: S7kRecord) -> ControlRequest:
    """Decode record 7500. Raises RecordError."""
    if len(record.body) < _REQUEST.size:
        raise RecordError(Loss.BAD_REMOTE_CONTROL)
    command, ticket, tracking = _REQUEST.unpack_from(record.body)
    return ControlRequest(command, ticket, record.body[_REQUEST.size :], tracking)


def encode_reply(request: ControlRequest, error: int | None, utc_ns: int, device: DeviceId) -> bytes:
    """Return record 7501, or 7502 when there is an error, framed."""
    body = _REPLY.pack(request.ticket, request.tracking)
    if error is None:
        return encode_record(ACKNOWLEDGED, body, utc_ns, device)
    return encode_record(REFUSED, body + _ERROR.pack(error), utc_ns, device)


def decode_reply(record: S7kRecord) -> ControlReply:
    """Decode record 7501 or 7502. Raises RecordError."""
    refused = record.record_type == REFUSED
    if len(record.body) < _REPLY.size + (_ERROR.size if refused else 0):
        raise RecordError(Loss.BAD_REMOTE_CONTROL)
    ticket, _ = _REPLY.unpack_from(record.body)
    return ControlReply(ticket, _ERROR.unpack_from(record.body, _REPLY.size)[0] if refused else None)
