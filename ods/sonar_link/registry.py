"""The table of protocols: `sonar.protocol` to the object that speaks with the sonar. One row each.

A row needs no import of the protocol, so that a process loads the one that it speaks. A plug-in adds a row:

    @sonar_protocol("sketch", transports={"serial", "tcp"}, sonars="the Sketch")
    class SketchProtocol(SonarProtocol):
        ...
"""

import importlib
from collections import Counter
from collections.abc import Callable, Set
from typing import TYPE_CHECKING, Any, NamedTuple

from ods.base.choices import none_of
from ods.base.plugins import PluginError, PluginGroup, add
from ods.runtime.port.address import PORT_FORMS, Transport, transport_of

if TYPE_CHECKING:
    from ods.sonar_link.protocol import SonarProtocol
    from ods.sonar_link.settings import SonarSettings

PLUGINS = PluginGroup("sonar.plugins", "ods.sonar")
"""Where protocols of the user's own are named."""


class ProtocolRow(NamedTuple):
    """One protocol. Its own settings are the field of its name in `SonarSettings`, if it has any."""

    factory: "str | type[SonarProtocol]"
    """`module:class` of the `SonarProtocol`, or a plug-in's class itself; called with `SonarSettings` and the counters
    of the process."""
    transports: frozenset[Transport]
    """What it is spoken over; `sonar.port` must name one of these."""
    sonars: str
    """Who speaks it, in a few words."""
    page: str
    """In docs/sonars/; "": the plug-in's author knows."""
    settable: frozenset[str] = frozenset()
    """Those of `range_m`, `power_db` and `gain_db` in `SonarSettings` that are sent to the sonar."""

    @property
    def made_by(self) -> Any:
        """The class."""
        if not isinstance(self.factory, str):
            return self.factory
        module, _, name = self.factory.partition(":")
        return getattr(importlib.import_module(module), name)


PROTOCOLS: dict[str, ProtocolRow] = {
    "s7k": ProtocolRow(
        "ods.sonar_link.s7k.protocol:S7kProtocol", frozenset({"serial", "tcp", "socket"}),
        "Teledyne RESON SeaBat and others of the 7k Data Format", "s7k.md",
        frozenset({"range_m", "power_db", "gain_db"}),
    ),
    "oculus": ProtocolRow(
        "ods.sonar_link.oculus.protocol:OculusProtocol", frozenset({"tcp"}), "Blueprint Subsea Oculus M series",
        "oculus.md",
    ),
    "norbit": ProtocolRow(
        "ods.sonar_link.norbit.protocol:NorbitProtocol", frozenset({"tcp"}), "Norbit WBMS FLS", "norbit.md",
    ),
    "ping360": ProtocolRow(
        "ods.sonar_link.ping360.protocol:Ping360Protocol", frozenset({"serial", "socket", "udp"}),
        "Blue Robotics Ping360", "ping360.md",
    ),
    "sonar3d15": ProtocolRow(
        "ods.sonar_link.sonar3d15.protocol:Sonar3d15Protocol", frozenset({"udp"}), "Water Linked Sonar 3D-15",
        "sonar3d15.md",
    ),
}  # fmt: skip
"""By the names that `sonar.protocol` may have."""


Register = Callable[["type[SonarProtocol]"], "type[SonarProtocol]"]


def sonar_protocol(name: str, *, transports: Set[Transport], sonars: str, settable: Set[str] = frozenset()) -> Register:
    """Register the decorated class; the arguments are those of `ProtocolRow`. Raises PluginError: the name is taken."""

    def register(factory: "type[SonarProtocol]") -> "type[SonarProtocol]":
        row = ProtocolRow(factory, frozenset(transports), sonars, "", frozenset(settable))
        add(PROTOCOLS, "sonar protocol", name, row)
        return factory

    return register


def unsupported_reason(settings: "SonarSettings") -> str:
    """Return the first setting that its protocol cannot do, as "port: ..."; "" when it can do all."""
    row = PROTOCOLS.get(settings.protocol)
    if row is None:
        return f"protocol: {none_of(settings.protocol, PROTOCOLS)}"
    if transport_of(settings.port) not in row.transports:
        spoken = ", ".join(sorted(row.transports))
        forms = " or ".join(PORT_FORMS[name] for name in sorted(row.transports))
        return f"port: {settings.port}: {settings.protocol} works over {spoken} only: write {forms}"
    for name in ("range_m", "power_db", "gain_db"):
        if getattr(settings, name) is not None and name not in row.settable:
            where = f", see docs/sonars/{row.page}" if row.page else ""
            return f"{name}: {settings.protocol} has its own settings{where}"
    return ""


def make_protocol(settings: "SonarSettings", counters: "Counter[str]") -> "SonarProtocol":
    """Return the protocol that the settings choose. Raises PluginError."""
    PLUGINS.load(settings.plugins)
    if wrong := unsupported_reason(settings):
        raise PluginError(f"sonar.{wrong}")
    protocol: SonarProtocol = PROTOCOLS[settings.protocol].made_by(settings, counters)
    return protocol
