"""The CAN interface: is it there, up, alive, and set so that it comes back by itself?"""

import json
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ods.doctor.finding import Finding
from ods.doctor.lines import serial_device
from ods.nav_bridge.settings import CanSettings

CAN_DEVICE = 280
"""ARPHRD_CAN: what /sys/class/net/*/type says of a CAN interface."""
LEAST_QUEUE = 10
"""Frames; Linux's own default for CAN. A shorter queue refuses bursts."""
IP_TIMEOUT_S = 5.0


def examine(settings: CanSettings) -> Iterator[Finding]:
    """Check the interface without sending anything."""
    subject = f"CAN {settings.interface} {settings.channel}"
    if settings.interface == "socketcan":
        yield from _network(subject, settings)
        return
    if settings.channel.startswith("/"):
        yield from serial_device.examine(subject, settings.channel, "nav.can.channel")
    else:
        yield Finding("note", subject, "is a python-can driver: tested when the nav process starts, or with --listen")
    if settings.interface == "slcan" and settings.bitrate is None:
        yield Finding("note", subject, "nav.can.bitrate is not set: the adapter must have its own")


def _network(subject: str, settings: CanSettings) -> Iterator[Finding]:
    folder = Path("/sys/class/net") / settings.channel
    try:
        flags, kind = int((folder / "flags").read_text(), 16), int((folder / "type").read_text())
        queue = int((folder / "tx_queue_len").read_text())
    except (OSError, ValueError):
        yield Finding("wrong", subject, "no such interface: `ip link` lists the existing ones")
        return
    if kind != CAN_DEVICE:
        yield Finding("wrong", subject, "is not a CAN interface: `ip link show type can` lists the existing ones")
        return
    if not flags & 1:
        yield Finding("wrong", subject, f"is down: `ip link set {settings.channel} up type can bitrate ...` as root")
        return
    yield from controller(subject, settings, _details(settings.channel))
    if 0 < queue < LEAST_QUEUE:
        yield Finding("note", subject, f"sends at most {queue} frames at once: `ip link set {settings.channel} "
                      "txqueuelen 100` as root")  # fmt: skip
    yield from _buffer(subject, settings.receive_buffer_bytes)


def controller(subject: str, settings: CanSettings, details: dict[str, Any]) -> Iterator[Finding]:
    """Judge what `ip -details -json link show` says of an interface that is up."""
    info = details.get("linkinfo", {})
    if info.get("info_kind") != "can":
        kind = info.get("info_kind", "an interface without details (is iproute2 installed?)")
        yield Finding("good", subject, f"is up ({kind})")
        return
    data = info.get("info_data", {})
    yield _state(subject, settings.channel, data)
    yield from _set_up(subject, settings, data)


def _state(subject: str, channel: str, data: dict[str, Any]) -> Finding:
    """Judge the controller's error state."""
    rate, sample_point = _bitrate(data), data.get("bittiming", {}).get("sample_point")
    state, restart_ms = data.get("state", "UNKNOWN"), data.get("restart_ms", 0)
    if state == "BUS-OFF":
        fault = f"is bus-off: wiring, termination or bit rate; `ip link set {channel} type can restart` as root"
        return Finding("wrong", subject, fault)
    if state not in ("ERROR-ACTIVE", "UNKNOWN"):
        fault = f"is {state.lower()}: no other node acknowledges, or the bit rate ({rate}) is wrong"
        return Finding("wrong", subject, fault)
    sampled = f", sample point {sample_point}" if sample_point else ""
    return Finding("good", subject, f"is up, {rate} bit/s{sampled}, {state.lower()}, restart-ms {restart_ms}")


def _set_up(subject: str, settings: CanSettings, data: dict[str, Any]) -> Iterator[Finding]:
    """Judge the controller's settings."""
    set_it = f"as root, with the interface down, `ip link set {settings.channel} type can"
    rate = _bitrate(data)
    if settings.bitrate not in (None, rate):
        yield Finding("wrong", subject, f"runs at {rate} bit/s, but nav.can.bitrate, not used by socketcan, says "
                      f"{settings.bitrate}: {set_it} bitrate {settings.bitrate}`, or remove the key")  # fmt: skip
    if "LISTEN-ONLY" in data.get("ctrlmode", []):
        yield Finding("note", subject, f"is listen-only, so ODS cannot send: {set_it} listen-only off`")
    if not data.get("restart_ms"):
        yield Finding("note", subject, f"stays off after bus-off: {set_it} restart-ms 100`")


def _bitrate(data: dict[str, Any]) -> int | None:
    """Return the bit rate; that of a controller with a fixed list of rates, such as slcan's, stands elsewhere."""
    found = data.get("bittiming", {}).get("bitrate", data.get("bittiming_bitrate"))
    return found if found is None else int(found)


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
