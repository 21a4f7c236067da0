"""Why a Ping360 sends no beam, in plain words, the likeliest cause first. Pure."""

from collections import Counter
from typing import NamedTuple

from ods.runtime.port.address import Transport
from ods.sonar_link.ping360.messages import PING360, Information, Kind


class Evidence(NamedTuple):
    """Evidence for the reason why no ping comes."""

    connected: bool
    transport: Transport
    port: str
    kinds: "Counter[int]"
    """Complete messages by kind."""
    counters: "Counter[str]"
    """Counters of damaged data."""
    refusal: str
    """Of the request to sweep."""
    said: Information | None
    """What the device says it is."""


def why(known: Evidence) -> str:
    """Return the reason, or what to check."""
    if not known.connected:
        return _unreachable(known)
    if known.said is not None and known.said.kind != PING360:
        return f"{known.port} is not a Ping360 (device type {known.said.kind}): a Ping1D uses another line"
    if known.refusal:
        return _refused(known)
    if known.kinds[Kind.DEVICE_DATA] or known.kinds[Kind.AUTO_DEVICE_DATA]:
        return "its beams cannot be decoded: see the counters"
    if known.counters["bad_checksum"]:
        return "its messages arrive damaged: check baud, cable, ground, and whether two programs use the line"
    if known.counters["garbage_bytes"]:
        return "the data received are not of the ping protocol: check sonar.baud and wiring; or is it another device?"
    if known.kinds:
        return "it answers, but sends no beam: can the head turn freely, and is the supply sufficient (11 to 25 V)?"
    return _silent(known)


def _unreachable(known: Evidence) -> str:
    if known.transport == "serial":
        return f"{known.port} cannot be opened: is the adapter connected? Does another program (a viewer) use it?"
    bridge = "the bridge (BlueOS: 'Ping Sonar Devices')"
    return f"nothing receives datagrams at {known.port}: is {bridge} running, and is its port correct?"


def _refused(known: Evidence) -> str:
    version = "" if known.said is None else f" {'.'.join(map(str, known.said.firmware))}"
    return (
        f"the sonar refused to sweep by itself ({known.refusal}): its firmware{version} is too old for automatic "
        "transmission (update it with the maker's viewer), or sonar.ping360 exceeds its limits"
    )


def _silent(known: Evidence) -> str:
    if known.transport == "serial":
        return (
            "connected, but no beam: is the sonar on (11 to 25 V), are A and B (or TX and RX) right, and do adapter "
            "and cable support sonar.baud (start with 115200)?"
        )
    return (
        "connected, but no beam: is the sonar on, is this computer in the bridge's network (`ip route get` its "
        "address), and does a firewall allow UDP both ways? A bridge serves one program at a time: end the viewer"
    )
