"""Why a Norbit sends no image, in plain words, the likeliest cause first. Pure."""

from collections import Counter
from typing import NamedTuple

from ods.sonar_link.norbit.packets import COMMAND_PORT, IMAGE_PORT, PacketKind

OTHER_PORTS = {PacketKind.BATHYMETRY: "bathymetry", PacketKind.SNIPPETS: "snippets", PacketKind.SIDE_SCAN: "side scan"}


class Evidence(NamedTuple):
    """Evidence for the reason why no ping comes."""

    connected: bool
    """The image port is connected."""
    commanded: bool
    """The command port is connected."""
    no_commands: str
    """Why the command port is not connected."""
    commands: bool
    """Whether commands are sent at all."""
    answered: bool
    objections: list[str]
    """What the sonar did not take."""
    host: str
    port: int
    kinds: "Counter[int]"
    """Complete packets by kind."""
    counters: "Counter[str]"
    """Counters of damaged data."""


def why(known: Evidence) -> str:
    """Return the reason, or what to check."""
    if not known.connected:
        return _unreachable(known)
    if known.kinds[PacketKind.IMAGE]:
        return "its images cannot be decoded: see the counters"
    for kind, name in OTHER_PORTS.items():
        if known.kinds[kind]:
            return f"it sends {name}, not images: these use sonar.port {known.port}, images use {IMAGE_PORT}"
    if known.counters["bad_checksum"]:
        return "its packets arrive damaged: check cable and switch"
    if known.counters["garbage_bytes"]:
        return f"the data received are not WBMS packets: is sonar.port {known.port} the image port, {IMAGE_PORT}?"
    return f"connected, but no image: {_silent(known)}"


def _unreachable(known: Evidence) -> str:
    if known.commanded:
        return (
            f"it accepts commands, but no connection at port {known.port}: images use {IMAGE_PORT}, "
            f"or a firewall blocks outgoing TCP {known.port}"
        )
    return (
        f"is the sonar on, and is this computer in the network of {known.host} (`ip route get {known.host}`)? "
        f"A firewall must allow outgoing TCP to {known.port} and {COMMAND_PORT}"
    )


def _silent(known: Evidence) -> str:
    if not known.commands:
        return (
            "it pings only after `set_power 1`, and no command is sent (sonar.norbit.command_port is 0): "
            "is the program running that sets it?"
        )
    if not known.commanded:
        return f"it pings only after `set_power 1`, and its command port cannot be reached: {known.no_commands}"
    if known.objections:
        return known.objections[0]
    if not known.answered:
        return "it has not answered any command yet"
    return (
        "it reports that it pings. Another connected program that does not read stalls all others: end it (the maker's "
        "viewer, a hung driver). Otherwise a firewall drops the images, or the sonar's licence does not include them"
    )
