"""CAN interfaces of the present network namespace, by `ip link`.

As a program, `links.py COMMAND...`: makes vcan0 and vcan1 in a namespace of its own, then becomes COMMAND.
"""

import fcntl
import os
import shutil
import socket
import struct
import subprocess
import sys

NAMES = ("vcan0", "vcan1")
SIOCGIFFLAGS = 0x8913
IFF_UP = 1


class LinkError(OSError):
    """`ip link` failed; the text is its own."""


def make(name: str) -> None:
    """Make a vcan interface and set it up."""
    _ip_link("add", "dev", name, "type", "vcan")
    up(name)


def delete(name: str) -> None:
    """Take an interface away, as pulling out a USB adapter does."""
    _ip_link("del", "dev", name)


def up(name: str) -> None:
    """Set an interface up."""
    _ip_link("set", "dev", name, "up")


def down(name: str) -> None:
    """Set an interface down."""
    _ip_link("set", "dev", name, "down")


def exists(name: str) -> bool:
    """Tell whether this network namespace has the interface."""
    return name in (known for _, known in socket.if_nameindex())


def is_up(name: str) -> bool:
    """Tell whether the interface is there and up."""
    if not exists(name):
        return False
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as sock:
        answer = fcntl.ioctl(sock, SIOCGIFFLAGS, struct.pack("16sH14x", name.encode(), 0))
    return bool(struct.unpack("16sH14x", answer)[1] & IFF_UP)


def ensure() -> list[str]:
    """Have vcan0 and vcan1 up, and sockets for them; return those that had to be made. Raises OSError.

    Fails as well where the links are there but the user may not set them: who tests a bus must be able to break it.
    """
    made: list[str] = []
    try:
        for name in NAMES:
            if exists(name):
                up(name)
            else:
                made.append(name)
                make(name)
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError:
        for name in filter(exists, made):
            delete(name)
        raise
    return made


def ip_program() -> str:
    """Return the path of iproute2's `ip`; it is not on the search path of every user. Raises LinkError."""
    found = shutil.which("ip", path=f"{os.environ.get('PATH', os.defpath)}:/usr/sbin:/sbin")
    if found is None:
        raise LinkError("no program `ip` (package iproute2)")
    return found


def _ip_link(*words: str) -> None:
    done = subprocess.run([ip_program(), "link", *words], capture_output=True, text=True)
    if done.returncode:
        raise LinkError(f"ip link {' '.join(words)}: {done.stderr.strip()}")


def main(command: list[str]) -> None:
    """Make the interfaces, then become the command."""
    try:
        up("lo")
        ensure()
    except OSError as error:
        sys.exit(str(error))
    os.execvp(command[0], command)


if __name__ == "__main__":
    main(sys.argv[1:])
