"""The CAN interface: is it there, up, alive, and set so that it comes back by itself?"""

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ods.doctor.finding import Finding
from ods.nav_bridge.settings import CanSettings

CAN_DEVICE = 280
"""ARPHRD_CAN: what /sys/class/net/*/type says of a CAN interface."""
LEAST_QUEUE = 10
"""Frames; Linux's own default for CAN. A shorter queue refuses bursts."""
IP_TIMEOUT_S = 5.0


def examine(settings: CanSettings) -> Iterator[Finding]:
    """Look at the interface without sending anything."""
    subject = f"CAN {settings.interface} {settings.channel}"
    if settings.interface == "socketcan":
        yield from _network(subject, settings)
    elif Path(settings.channel).exists() or not settings.channel.startswith("/"):
        rate = f", {settings.bitrate} bit/s" if settings.bitrate else ""
        yield Finding("good", subject, f"is there{rate}")
        if settings.interface == "slcan" and settings.bitrate is None:
            yield Finding("note", subject, "nav.can.bitrate is not given: the adapter must have one of its own")
    else:
        yield Finding("wrong", subject, "no such device: is the adapter plugged in, and nav.can.channel right?")


def _network(subject: str, settings: CanSettings) -> Iterator[Finding]:
    folder = Path("/sys/class/net") / settings.channel
    try:
        flags, kind = int((folder / "flags").read_text(), 16), int((folder / "type").read_text())
        queue = int((folder / "tx_queue_len").read_text())
    except (OSError, ValueError):
        yield Finding("wrong", subject, "no such interface: `ip link` lists those that are there")
        return
    if kind != CAN_DEVICE:
        yield Finding("wrong", subject, "is no CAN interface: `ip link show type can` lists those that are there")
        return
    if not flags & 1:
        yield Finding("wrong", subject, f"is down: `ip link set {settings.channel} up type can bitrate ...` as root")
        return
    yield from controller(subject, settings.channel, _details(settings.channel))
    if 0 < queue < LEAST_QUEUE:
        yield Finding("note", subject, f"sends at most {queue} frames at once: `ip link set {settings.channel} "
                      "txqueuelen 100` as root")  # fmt: skip
    yield from _buffer(subject, settings.receive_buffer_bytes)


def controller(subject: str, channel: str, details: dict[str, Any]) -> Iterator[Finding]:
    """Judge what `ip -details -json link show` says of an interface that is up."""
    info = details.get("linkinfo", {})
    data = info.get("info_data", {})
    if info.get("info_kind") != "can":
        kind = info.get("info_kind", "an interface that tells no more (is iproute2 installed?)")
        yield Finding("good", subject, f"is up ({kind})")
        return
    rate = data.get("bittiming", {}).get("bitrate")
    state, restart_ms = data.get("state", "UNKNOWN"), data.get("restart_ms", 0)
    if state == "BUS-OFF":
        yield Finding("wrong", subject, "is bus-off: wiring, termination or bit rate; `ip link set "
                      f"{channel} type can restart` as root")  # fmt: skip
    elif state not in ("ERROR-ACTIVE", "UNKNOWN"):
        yield Finding("wrong", subject, f"is {state.lower()}: nobody acknowledges, or the bit rate ({rate}) is wrong")
    else:
        yield Finding("good", subject, f"is up, {rate} bit/s, {state.lower()}, restart-ms {restart_ms}")
    if not restart_ms:
        dead = "stays dead after bus-off: as root, with the interface down,"
        yield Finding("note", subject, f"{dead} `ip link set {channel} type can restart-ms 100`")


def _details(channel: str) -> dict[str, Any]:
    """Return what iproute2 knows, {} when it is not installed."""
    command = ["ip", "-details", "-json", "link", "show", "dev", channel]
    try:
        done = subprocess.run(command, capture_output=True, timeout=IP_TIMEOUT_S, check=True)
        found = json.loads(done.stdout)
    except (OSError, subprocess.SubprocessError, ValueError):
        return {}
    return dict(found[0]) if found else {}


def _buffer(subject: str, wanted: int) -> Iterator[Finding]:
    """Compare the receive buffer wanted with what this user may have."""
    try:
        most = int(Path("/proc/sys/net/core/rmem_max").read_text())
        capabilities = next(
            int(line.split()[1], 16)
            for line in Path("/proc/self/status").read_text().splitlines()
            if line.startswith("CapEff")
        )
    except (OSError, ValueError, StopIteration):
        return
    net_admin = 1 << 12
    if most < wanted and not capabilities & net_admin:
        yield Finding("note", subject, f"the receive buffer will be {most} bytes instead of {wanted}: raise "
                      "net.core.rmem_max, or give the process CAP_NET_ADMIN")  # fmt: skip
