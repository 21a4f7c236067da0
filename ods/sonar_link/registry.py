"""The table of protocols: `sonar.protocol` to the object that speaks with the sonar. One row each.

A row needs no import of the protocol, so that a process loads the one that it speaks.
"""

import importlib
from collections import Counter
from typing import TYPE_CHECKING, NamedTuple

from ods.runtime.port.address import Transport

if TYPE_CHECKING:
    from ods.sonar_link.protocol import SonarProtocol
    from ods.sonar_link.settings import SonarSettings


class ProtocolRow(NamedTuple):
    """One protocol. Its own settings are the field of its name in `SonarSettings`, if it has any."""

    factory: str
    """`module:class` of the `SonarProtocol`; called with `SonarSettings` and the counters of the process."""
    transports: frozenset[Transport]
    """What it is spoken over; `sonar.port` must name one of these."""
    sonars: str
    """Who speaks it, in a few words."""
    page: str
    """In docs/."""
    knobs: frozenset[str] = frozenset()
    """Those of `range_m`, `power_db` and `gain_db` in `SonarSettings` that are sent to the sonar."""


PROTOCOLS: dict[str, ProtocolRow] = {
    "s7k": ProtocolRow(
        "ods.sonar_link.s7k.protocol:S7kProtocol", frozenset({"serial", "tcp", "socket"}),
        "Teledyne RESON SeaBat and others of the 7k Data Format", "sonar-s7k.md",
        frozenset({"range_m", "power_db", "gain_db"}),
    ),
    "oculus": ProtocolRow(
        "ods.sonar_link.oculus.protocol:OculusProtocol", frozenset({"tcp"}), "Blueprint Subsea Oculus M series",
        "oculus.md",
    ),
}  # fmt: skip
"""By the names that `sonar.protocol` may have."""


def make_protocol(settings: "SonarSettings", counters: "Counter[str]") -> "SonarProtocol":
    """Return the protocol that the settings choose."""
    module, _, name = PROTOCOLS[settings.protocol].factory.partition(":")
    protocol: SonarProtocol = getattr(importlib.import_module(module), name)(settings, counters)
    return protocol
