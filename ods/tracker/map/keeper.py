"""Keeps the map file in step with the tracker by a process of its own (`writer`): nothing here waits for a disk."""

import logging
import math
from collections.abc import Callable, Iterable
from pathlib import Path

import msgspec

from ods.base.clock import NS
from ods.tracker.map.link import OBJECTS_A_PACKET, Change, Failed, Known, LinkEndedError, Written
from ods.tracker.map.map_object import MapObject
from ods.tracker.map.pending import PendingChanges
from ods.tracker.map.write_delay import READ, WRITTEN, WriteDelay
from ods.tracker.map.writer_process import WriterProcess
from ods.tracker.restart.ids import ID_BLOCK, PROVISIONAL_IDS
from ods.tracker.settings import MapSettings

log = logging.getLogger(__name__)

WRITE_PERIOD_NS = NS
"""Between two changes of the file: a kill loses no more than this."""
WAIT_S = 1.0
"""Time for which the tracker's start waits for the map, and its end for the last change, s; later the map's process
continues alone."""
PACKETS_A_ROUND = 4
"""What is read of the map, 200 objects each, may keep the tracker from a list for some ms."""


def of_earlier_mission(known: MapObject, position_sigma_m: float) -> MapObject:
    """Return an object as far as it can be relied on in another mission, whose pose has other errors."""
    north, east = (math.hypot(s, position_sigma_m) for s in known.sigma[:2])
    return msgspec.structs.replace(known, sigma=(north, east, known.sigma[2]))


class MapKeeper:
    """Collects changes, has them written one at a time, and hands out what earlier missions left."""

    def __init__(
        self,
        settings: MapSettings,
        origin_deg: tuple[float, float],
        run_dir: Path,
        complain: Callable[[str, str], None],
    ) -> None:
        """`origin_deg`: latitude and longitude of the local frame; `complain` takes a counter's name and a line."""
        self.pending = PendingChanges()
        self._settings = settings
        self._name = f"map {settings.path}"
        self._writer = None if settings.path is None else WriterProcess(settings.path, origin_deg, run_dir)
        self._lag = WriteDelay(self._name, complain)
        self._complain = complain
        self._open = False
        self._reserved = 0
        self._sent: Change | None = None
        self._due_ns = 0

    @property
    def to_be_read(self) -> bool:
        """There is a map, and not all that is in it was handed out yet."""
        return self._writer is not None and self._lag.wanted == READ

    def problem(self, now_ns: int) -> str:
        """Return what is wrong with the file; empty when nothing is."""
        return self._lag.problem(now_ns)

    def note(self, hibernated: Iterable[MapObject], gone: Iterable[int]) -> None:
        """Take in what a step changed."""
        if self._writer is None:
            return
        for o in hibernated:
            if not math.isfinite(sum((*o.position, *o.sigma, o.radius, o.sigma_radius, o.existence, o.covariance_ne))):
                self._complain("map_not_finite", f"object {o.id} is not finite and is not stored in the map")
            elif o.times_seen >= self._settings.minimum_times_seen:
                self.pending.put(o)
        for object_id in gone:
            self.pending.remove(object_id)

    def poll(self, now_ns: int, next_id: int) -> Known | None:
        """Continue pending work without waiting; return what was read of the file meanwhile.

        Ids are kept reserved ahead of `next_id`, that of the next new object.
        """
        if self._writer is None:
            return None
        known = None
        try:
            if self._writer.start(now_ns):
                self._lag.begin(now_ns)
            known = self._hear(self._writer, now_ns)
            self._write(self._writer, now_ns, next_id)
        except LinkEndedError as error:
            self._open, self._sent = False, None
            self._writer.lost(now_ns)
            self._lag.failed(f"{self._name}: its process ended ({error})")
            self._complain("map_process_lost", f"{self._name}: its process ended; restarting it")
        self._lag.look(now_ns, self._writer.starved(now_ns))
        return known

    def close(self, next_id: int) -> None:
        """Have all that is left written, and ids not used given back; a disk that stalls is not waited for."""
        if self._writer is None:
            return
        given_back = next_id if self._open and next_id < PROVISIONAL_IDS else None
        said = self._writer.finish([*self.pending.all(), Change([], [], given_back)], WAIT_S)
        if said is None and self.pending:
            log.warning("%s: %d changes were not written when the tracker ended", self._name, len(self.pending))
        for message in said or ():
            if isinstance(message, Failed):
                self._complain("map_write_failed", message.reason)

    def _hear(self, writer: WriterProcess, now_ns: int) -> Known | None:
        """Take what the map's process says. Raises LinkEndedError."""
        objects: list[MapObject] = []
        first_id = None
        for _ in range(PACKETS_A_ROUND):
            message = writer.receive()
            if isinstance(message, Known):
                objects += message.objects
                first_id = message.first_id
                if first_id is not None:
                    writer.works()
                    break
            elif isinstance(message, Written):
                self._written(now_ns)
            elif isinstance(message, Failed):
                self._sent = None
                self._lag.failed(message.reason)
                self._complain("map_write_failed" if message.opened else "map_unusable", message.reason)
        return self._handed_out(objects, first_id, now_ns) if objects or first_id is not None else None

    def _handed_out(self, objects: list[MapObject], first_id: int | None, now_ns: int) -> Known | None:
        """Return what is news to the tracker: a process that was started again reads the file again."""
        news = self.to_be_read
        if first_id is not None:
            self._open, self._due_ns = True, now_ns
            self._reserved = max(self._reserved, first_id)
            self._lag.done(now_ns)
            self._lag.wanted = WRITTEN
        gone = self.pending.removes
        sigma_m = self._settings.position_sigma_m
        return Known([of_earlier_mission(o, sigma_m) for o in objects if o.id not in gone], first_id) if news else None

    def _written(self, now_ns: int) -> None:
        if self._sent is not None:
            self.pending.written(self._sent)
            self._reserved = max(self._reserved, self._sent.next_id or 0)
        self._sent = None
        self._lag.done(now_ns)

    def _write(self, writer: WriterProcess, now_ns: int, next_id: int) -> None:
        """Have the next changes written, if it is time. Raises LinkEndedError."""
        if not self._open or self._sent is not None or now_ns < self._due_ns:
            return
        change = self.pending.first()
        if next_id < PROVISIONAL_IDS and next_id + ID_BLOCK // 2 > self._reserved:
            change = msgspec.structs.replace(change, next_id=next_id + ID_BLOCK)
        elif not self.pending:
            return
        if writer.send(change):
            full = len(change.put) == OBJECTS_A_PACKET
            self._sent, self._due_ns = change, now_ns + (0 if full else WRITE_PERIOD_NS)
            self._lag.begin(now_ns)
