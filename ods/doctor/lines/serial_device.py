"""A serial device, of the sonar or of a CAN adapter: is it there, usable, named for good, and prompt?"""

import os
import stat
from collections.abc import Iterator
from pathlib import Path

from ods.doctor.finding import Finding

BY_NUMBER = ("/dev/ttyUSB", "/dev/ttyACM")
USB_SERIAL = Path("/sys/bus/usb-serial/devices")
PROMPT_MS = 2
"""A latency timer up to this is short beside everything else."""


def examine(subject: str, device: str, key: str) -> Iterator[Finding]:
    """Check a device without opening it; key: the setting that names it."""
    try:
        status = Path(device).stat()
    except OSError as error:
        yield Finding("wrong", subject, f"{error.strerror}: is the adapter plugged in, and is {key} correct?")
        return
    if not stat.S_ISCHR(status.st_mode):
        yield Finding("wrong", subject, "is not a serial device")
    elif not os.access(device, os.R_OK | os.W_OK):
        yield Finding("wrong", subject, "cannot be read and written by this user: join the group `dialout`")
    else:
        yield Finding("good", subject, f"is there ({os.path.realpath(device)})")
        if device.startswith(BY_NUMBER):
            yield Finding("note", subject, "may change its number when replugged: use its name in /dev/serial/by-id")
        yield from latency_timer(subject, device)


def latency_timer(subject: str, device: str, devices: Path = USB_SERIAL) -> Iterator[Finding]:
    """Report an adapter that delays the end of received data, as FTDI's do: 16 ms unless set otherwise.

    Source: FTDI, AN232B-04, "Small amounts of data and end of buffer conditions". `devices`: the kernel's list.
    """
    file = devices / Path(os.path.realpath(device)).name / "latency_timer"
    try:
        held_ms = int(file.read_text())
    except (OSError, ValueError):
        return
    if held_ms > PROMPT_MS:
        yield Finding("note", subject, f"the adapter holds back the last bytes for up to {held_ms} ms: "
                      f"`echo 1 > {file}` as root, or the udev rule in docs/sonars/s7k.md")  # fmt: skip
