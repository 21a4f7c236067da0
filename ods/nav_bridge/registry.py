"""The register of navigation sources: `nav.source` to the object that speaks with it, and to its line."""

from collections import Counter
from typing import Any

from ods.base import clock
from ods.base.geodesy import LocalFrame
from ods.nav_bridge.can.link import CanLink
from ods.nav_bridge.can.source import CanSource
from ods.nav_bridge.canopen.source import CanopenSource
from ods.nav_bridge.clocks.utc import Utc, WallClock
from ods.nav_bridge.dbc.source import DbcSource
from ods.nav_bridge.link import Descriptor, Link
from ods.nav_bridge.nmea.link import NmeaLink
from ods.nav_bridge.nmea.source import NmeaSource
from ods.nav_bridge.settings import NavSettings
from ods.nav_bridge.source import PoseSource, Send, SourceHost


def make_source(nav: NavSettings, frame: LocalFrame, send: Send, counters: Counter[str]) -> PoseSource[Any]:
    """Return the source that the settings choose. Raises OdsError when its files cannot be used."""
    host = SourceHost(frame, send, counters, clock.monotonic_ns(), Utc(_wall_clock))
    if nav.source == "nmea":
        assert nav.nmea is not None  # `NavSettings` has seen to it
        return NmeaSource(nav, nav.nmea, host)
    if nav.source == "dbc":
        assert nav.dbc is not None
        return DbcSource(nav, nav.dbc, host)
    assert nav.canopen is not None
    return CanopenSource(nav, nav.canopen, host)


def make_link(
    nav: NavSettings, source: PoseSource[Any], counters: Counter[str], opened: Descriptor, closing: Descriptor
) -> Link[Any]:
    """Return the line to a source; `opened` and `closing` are told of its descriptor."""
    if isinstance(source, CanSource):
        return CanLink(nav.can, source.ids, counters, opened, closing)
    assert nav.nmea is not None
    return NmeaLink(nav.nmea, counters, opened, closing)


def _wall_clock() -> WallClock:
    return WallClock(clock.utc_offset_ns(), clock.synchronized())
