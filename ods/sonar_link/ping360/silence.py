"""Why a Ping360 sends no beam, in plain words, the likeliest cause first. Pure."""

from collections import Counter
from typing import NamedTuple

from ods.runtime.port.address import Transport
from ods.sonar_link.ping360.messages import PING360, Information, Kind


class Evidence(NamedTuple):
    """What is known when no ping comes."""

    connected: bool
    transport: Transport
    port: str
    kinds: "Counter[int]"
    """Whole messages by kind,"""
    counters: "Counter[str]"
    """and what was no message."""
    refusal: str
    """Of the wish to sweep."""
    said: Information | None
    """What the device says it is."""


def why(known: Evidence) -> str:
    """Return the reason, or what to look at."""
    if not known.connected:
        return _unreachable(known)
    if known.said is not None and known.said.kind != PING360:
        return f"what answers at {known.port} is no Ping360 (device type {known.said.kind}): a Ping1D has another line"
    if known.refusal:
        return _refused(known)
    if known.kinds[Kind.DEVICE_DATA] or known.kinds[Kind.AUTO_DEVICE_DATA]:
        return "its beams cannot be used: see the counters"
    if known.counters["bad_checksum"]:
        return "its messages come damaged: baud, cable, ground, or two programs on one line"
    if known.counters["garbage_bytes"]:
        return "what comes is no message of the ping protocol: sonar.baud, wiring, or another device"
    if known.kinds:
        return "it answers, but sends no beam: is the head free to turn, and the supply strong enough (11 to 25 V)?"
    return _silent(known)


def _unreachable(known: Evidence) -> str:
    if known.transport == "serial":
        return f"{known.port} cannot be opened: is the adapter in, and no other program (the maker's viewer) on it?"
    bridge = "the bridge (BlueOS: 'Ping Sonar Devices')"
    return f"nothing receives datagrams at {known.port}: is {bridge} on and its port right?"


def _refused(known: Evidence) -> str:
    version = "" if known.said is None else f" {'.'.join(map(str, known.said.firmware))}"
    return (
        f"the sonar refused to sweep by itself ({known.refusal}): its firmware{version} is too old for automatic "
        "transmission, update it by the maker's viewer; or sonar.ping360 asks for what it cannot"
    )


def _silent(known: Evidence) -> str:
    if known.transport == "serial":
        return (
            "connected, but no beam: is the sonar on (11 to 25 V), do A and B (or TX and RX) fit, and is sonar.baud "
            "one that adapter and cable carry (115200 at first)?"
        )
    return (
        "connected, but no beam: is the sonar on, is this computer in the bridge's network (`ip route get` its "
        "address), and does a firewall let UDP out and back? A bridge serves one program at a time: end the viewer"
    )
