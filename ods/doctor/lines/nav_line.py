"""The line to the navigation source: a CAN interface, a serial device, or a network port."""

from collections.abc import Iterator

from ods.doctor.finding import Finding
from ods.doctor.lines import can_interface, serial_device
from ods.nav_bridge.settings import NavSettings


def examine(settings: NavSettings) -> Iterator[Finding]:
    """Check the line without sending anything."""
    if settings.source != "nmea":
        yield from can_interface.examine(settings.can)
        return
    assert settings.nmea is not None  # `NavSettings` has seen to it
    port = settings.nmea.port
    subject = f"NMEA {port}"
    if "://" in port:
        yield Finding("note", subject, "is tested when the nav process starts, or with --listen")
    else:
        yield from serial_device.examine(subject, port, "nav.nmea.port")
