"""What all ports that are a socket have in common."""

import os
import socket

from ods.runtime.port.port import Port


class SocketPort(Port):
    """A port that is one socket, which `_begin_opening` makes."""

    _socket: socket.socket | None = None

    def _descriptor(self) -> int:
        return self._connection().fileno()

    def _release(self) -> None:
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _connection(self) -> socket.socket:
        assert self._socket is not None
        return self._socket

    def _raise_error(self) -> None:
        """Raise what the socket has to tell, such as that nobody listens there."""
        error = self._connection().getsockopt(socket.SOL_SOCKET, socket.SO_ERROR)
        if error:
            raise OSError(error, os.strerror(error))
