"""Result of every decoder of files: the pings of a recording, made when they are asked for."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from ods.base.arrays import AnyArray, Floats
from ods.base.errors import OdsError
from ods.base.files.lazy_sequence import LazySequence
from ods.messages import Ping
from ods.sonar_link.ping_builder import Geometry, Runs, Stamp, build_ping

FARTHEST_M = 1e7
"""From an origin on the earth, as it is no larger; a position farther away is invalid."""


class PingFileError(OdsError):
    """A file of pings cannot be used; the text is one line: file and reason."""


class LazyPings(LazySequence[Ping]):
    """`count` pings, each made by `make(index)` when asked for, so that a long recording need not fit in memory."""

    def __init__(self, count: int, make: Callable[[int], Ping]) -> None:
        self._count = count
        self._make = make

    def __len__(self) -> int:
        return self._count

    def item(self, place: int) -> Ping:
        """Make one."""
        return self._make(place)


def recorded_ping(
    frame: AnyArray,
    geometry: Geometry,
    index: int,
    t_ns: int = 0,
    ping_number: int | None = None,
    no_data: Runs | None = None,
) -> Ping:
    """Return one ping of a file with one time a ping, and perhaps the sonar's own number of it.

    no_data: see `build_ping`. Raises ValueError when the (beams, samples) frame does not fit the geometry.
    """
    number = index if ping_number is None else ping_number
    return build_ping(frame, geometry, Stamp(index, number, t_ns, t_ns, t_ns), no_data)


@dataclass(frozen=True, eq=False)
class PingSequence:
    """A recording."""

    pings: Sequence[Ping]
    timed: bool = True
    """False when nothing is known of the times: the pings are single images."""
    position_ned: Floats | None = None
    """(pings, 3) the vehicle at transmission, m."""
    attitude: Floats | None = None
    """(pings, 4) unit quaternions w, x, y, z, body to global; present together with `position_ned`."""
    truth: Floats | None = None
    """(pings, objects, 7) x, y, z, vx, vy, vz, r, global NED; nan where absent."""
    losses: Counter[str] = field(default_factory=Counter)
    """What the file holds and the pings do not, by kind."""
