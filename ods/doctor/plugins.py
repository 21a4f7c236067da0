"""Parts of the user's own, but for stages (chain.py): are they found, and do they get through their first work?"""

from collections import Counter
from collections.abc import Iterator

from ods.base import clock
from ods.base.plugins import reason
from ods.config import OnboardConfig
from ods.doctor.finding import Finding
from ods.sonar_link.files.decoder import PLUGGED_IN, PLUGINS as DECODERS
from ods.sonar_link.files.settings import RecordingsSettings
from ods.sonar_link.registry import PLUGINS as PROTOCOLS, make_protocol
from ods.sonar_link.settings import SonarSettings
from ods.tracker.settings import OWN_ASSOCIATIONS, OWN_OBSERVERS, PLUGINS as TRACKER, TrackerSettings

NOISE = bytes(range(256)) * 4
"""What comes over a line to which something else is wired."""


def examine(settings: OnboardConfig) -> Iterator[Finding]:
    """Check the configured plug-ins."""
    yield from _tracker(settings.tracker)
    yield from _protocol(settings.sonar)
    yield from _decoders(settings.recordings)


def _tracker(settings: TrackerSettings) -> Iterator[Finding]:
    """Let observer and association follow a made-up mission."""
    own = settings.observer in OWN_OBSERVERS and settings.association in OWN_ASSOCIATIONS
    if own and not TRACKER.may_add(settings.plugins):
        return
    from ods.tracker.warm_up import warm_up  # slow to import

    try:
        warm_up(settings)
    except Exception as error:
        yield Finding("wrong", "tracker", reason(error))
    else:
        chosen = f"observer {settings.observer} and association {settings.association}"
        yield Finding("good", "tracker", f"{chosen} pass a synthetic mission")


def _protocol(settings: SonarSettings) -> Iterator[Finding]:
    """Let the protocol live through a connection on which nothing but noise comes."""
    if not PROTOCOLS.may_add(settings.plugins):
        return
    now_ns = clock.monotonic_ns()
    try:
        protocol = make_protocol(settings, Counter())
        protocol.connected(now_ns)
        protocol.feed(NOISE, now_ns)
        protocol.check(now_ns + clock.NS)
        protocol.requests(now_ns)
        protocol.problems(now_ns)
        protocol.end_stream(now_ns)
    except Exception as error:
        yield Finding("wrong", "sonar protocol", reason(error))
    else:
        yield Finding("good", "sonar protocol", f"{settings.protocol} is known and survives noise")


def _decoders(settings: RecordingsSettings) -> Iterator[Finding]:
    if not DECODERS.may_add(settings.plugins):
        return
    try:
        DECODERS.load(settings.plugins)
    except Exception as error:
        yield Finding("wrong", "recordings", reason(error))
    else:
        yield Finding("good", "recordings", f"decoders plugged in: {', '.join(PLUGGED_IN) or 'none'}")
