"""The sonar's port."""

import os
import stat
from collections.abc import Iterator
from pathlib import Path

from ods.doctor.finding import Finding


def serial_port(port: str) -> Iterator[Finding]:
    """Look at the sonar's serial device without opening it: opening would disturb a running sonar process."""
    subject = f"serial port {port}"
    if "://" in port:
        yield Finding("note", subject, "is a URL; it is tried when the sonar process starts")
        return
    try:
        status = Path(port).stat()
    except OSError as error:
        yield Finding("wrong", subject, f"{error.strerror}: is the adapter plugged in, and sonar.port right?")
        return
    if not stat.S_ISCHR(status.st_mode):
        yield Finding("wrong", subject, "is no serial device")
    elif not os.access(port, os.R_OK | os.W_OK):
        yield Finding("wrong", subject, "may not be read and written by this user: join the group `dialout`")
    else:
        yield Finding("good", subject, f"is there ({os.path.realpath(port)})")
