"""The socket between the tracker and the map's process, and what goes over it: one message a packet."""

import socket
from collections.abc import Sequence

import msgspec

from ods.base.errors import OdsError
from ods.tracker.map.map_object import MapObject

PACKET_BYTES = 1 << 18
OBJECTS_A_PACKET = 200
"""80 kB: Linux takes no packet larger than its send buffer, 200 kB as a rule."""
FIRST_DELAY_S, LONGEST_DELAY_S = 0.5, 15.0
"""Between attempts to open the file, and until its process is started again."""


class Change(msgspec.Struct, frozen=True, tag=True):
    """To the map's process: write this, all or nothing, and say so."""

    put: Sequence[MapObject]
    remove: Sequence[int]
    next_id: int | None = None
    """All ids below may be in use; None: as it was."""


class Known(msgspec.Struct, frozen=True, tag=True):
    """From the map's process: objects of earlier missions, in several messages."""

    objects: list[MapObject]
    first_id: int | None = None
    """With the last of them: an id from which on none was ever used."""


class Written(msgspec.Struct, frozen=True, tag=True):
    """From the map's process: the last change is on disk."""


class Failed(msgspec.Struct, frozen=True, tag=True):
    """From the map's process: the last change is not; or the file cannot be opened, which is tried again."""

    reason: str
    """One line."""
    opened: bool


Message = Change | Known | Written | Failed


class LinkEndedError(OdsError):
    """The other side has gone."""


class Link:
    """One end."""

    def __init__(self, end: socket.socket) -> None:
        """`end`: of a pair of SOCK_SEQPACKET; whether it blocks is the caller's choice."""
        self._socket = end
        self._buffer = memoryview(bytearray(PACKET_BYTES))
        self._encoder = msgspec.msgpack.Encoder()
        self._decoder: msgspec.msgpack.Decoder[Message] = msgspec.msgpack.Decoder(Message)

    def fileno(self) -> int:
        """Return the descriptor, to wait for."""
        return self._socket.fileno()

    def send(self, message: Message) -> bool:
        """Send one message; False when there is no room for it just now. Raises LinkEndedError."""
        try:
            self._socket.send(self._encoder.encode(message), socket.MSG_NOSIGNAL)
        except BlockingIOError:
            return False
        except OSError as error:
            raise LinkEndedError(str(error)) from error
        return True

    def receive(self) -> Message | None:
        """Return the next message; None when there is none just now. Raises LinkEndedError."""
        try:
            count = self._socket.recv_into(self._buffer)
        except BlockingIOError:
            return None
        except OSError as error:
            raise LinkEndedError(str(error)) from error
        if count == 0:
            raise LinkEndedError("closed")
        return self._decoder.decode(self._buffer[:count])

    def end(self) -> None:
        """Say that no message follows; those on the way still arrive."""
        try:
            self._socket.shutdown(socket.SHUT_WR)
        except OSError:  # the other side has gone
            return

    def close(self) -> None:
        """Give the socket back."""
        self._socket.close()
