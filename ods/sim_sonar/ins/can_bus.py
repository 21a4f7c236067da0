"""The CAN bus between the simulated vehicle and the on-board side."""

import socket
from pathlib import Path
from typing import Literal

VCAN = "vcan0"
SLCAN_PORT = "can0"


def can_of(wanted: Literal["auto", "vcan0", "slcan"], run_dir: Path) -> tuple[str, str]:
    """Return python-can's interface and channel for the on-board side: vcan0 where the kernel has it, else slcan."""
    if wanted == VCAN or (wanted == "auto" and has_vcan()):
        return "socketcan", VCAN
    return "slcan", str(run_dir / SLCAN_PORT)


def planner_can_of(wanted: Literal["auto", "vcan0", "slcan"], run_dir: Path) -> tuple[str, str]:
    """Return the same for the planner: on slcan an adapter of its own."""
    interface, channel = can_of(wanted, run_dir)
    return interface, f"{channel}-planner" if interface == "slcan" else channel


def has_vcan() -> bool:
    """Return whether vcan0 is there and a CAN socket opens on it."""
    try:
        with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as sock:
            sock.bind((VCAN,))
    except OSError:
        return False
    return True
