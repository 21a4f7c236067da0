"""Joins s7k records into pings: settings and beam geometry with the samples of the same ping. Pure.

What a ping says of itself comes from the records sent with it, so a change of range, sound speed or beams takes effect
at that very ping. A ping whose settings or geometry were lost is dropped and counted, never guessed.

A sonar may send its beam table with each ping or only when it changes. All records of one ping bear the same 7KTIME, so
a table with that of a ping's samples is the ping's own. Where most of the last HABIT pings had their own, one without
has lost it; else the table that was sent last holds.
"""

from collections import Counter, deque
from collections.abc import Callable

from ods.messages import Ping
from ods.sonar_link.ping_builder import BeamTable, Geometry, build_ping
from ods.sonar_link.s7k import records
from ods.sonar_link.s7k.drf import Record
from ods.sonar_link.s7k.water_column import RecordError, WaterColumn

NS = 1_000_000_000
KEPT = 4
"""Settings and beam tables kept of each sonar: a sonar may announce the next ping before this one's samples are out."""
HABIT = 8
"""Pings by which a sonar's way to send beam tables is told."""
LEAST_HABIT = 4
"""Fewer pings tell nothing: a sonar may announce its beams more than once at its start."""
MAX_SONARS = 8
MAX_GAP = 1000
"""A ping number further ahead than this is a sonar that started afresh, not pings lost."""

TimeMap = Callable[[int, int], int]
"""(device time, arrival) to the local time of that device time; all ns."""


def device_time(device_ns: int, _arrival_ns: int) -> int:
    """Return the device's own time: the map for files."""
    return device_ns


class Assembler:
    """Takes records in the order of their arrival and returns pings.

    Counters: pings; lost_pings (numbers that never became a ping, for whatever reason), duplicate_pings,
    ping_number_restarts; data_without_settings, data_without_geometry; bad_settings, bad_beam_table, bad_water_column,
    unsupported_layout, bad_ping (records that do not fit each other); other_records; no_device_time.
    """

    def __init__(
        self,
        new_time_map: Callable[[], TimeMap] = lambda: device_time,
        latency_ns: int = 0,
        counters: "Counter[str] | None" = None,
    ) -> None:
        """Make an assembler.

        `new_time_map` is called for each sonar, as each has its own clock; `latency_ns`: from the last sample's arrival
        at the sonar to its record's first byte.
        """
        self.counters: Counter[str] = Counter() if counters is None else counters
        self._new_time_map = new_time_map
        self._latency_ns = latency_ns
        self._sonars: dict[tuple[int, int], _Sonar] = {}
        self._seq = 0

    def feed(self, record: Record) -> Ping | None:
        """Take one record; return the ping that it completes."""
        sonar = self._sonar(record)
        try:
            decoded = records.decode(record)
            if isinstance(decoded, WaterColumn):
                return self._complete(record, decoded, sonar)
        except RecordError as reason:
            self.counters[str(reason)] += 1
            if record.record_type == records.BEAM_GEOMETRY:
                sonar.tables.append((record.time_ns, None))  # its ping must not get an older table
            return None
        if isinstance(decoded, BeamTable):
            sonar.tables.append((record.time_ns, decoded))
        elif decoded is not None:
            sonar.settings.append(decoded)
        else:
            self.counters["other_records"] += 1
        return None

    def _sonar(self, record: Record) -> "_Sonar":
        key = record.device, record.enumerator
        if key not in self._sonars and len(self._sonars) >= MAX_SONARS:
            self._sonars.clear()
        if key not in self._sonars:
            self._sonars[key] = _Sonar(self._new_time_map())
        return self._sonars[key]

    def _complete(self, record: Record, data: WaterColumn, sonar: "_Sonar") -> Ping:
        if sonar.delivered == (data.ping_number, data.multi_ping):
            raise RecordError("duplicate_pings")
        settings = sonar.settings_of(data)
        table = sonar.table_at(record.time_ns)
        try:
            geometry = _geometry(settings, table, data)
            listened_m = geometry.range0_m + (data.frame.shape[1] - 1) * geometry.dr_m
            delay_ns = round(2.0 * listened_m / geometry.sound_speed * NS) + self._latency_ns
            t_ns, utc_ns = self._transmit_time(record, delay_ns, sonar.map_time)
            ping = build_ping(
                data.frame, geometry, seq=self._seq, ping_number=data.ping_number, t_ns=t_ns,
                t_rx_ns=record.last_ns, utc_ns=utc_ns,
            )  # fmt: skip
        except ValueError:
            raise RecordError("bad_ping") from None
        self._count_gap(sonar.delivered, data.ping_number)
        sonar.delivered = data.ping_number, data.multi_ping
        self._seq += 1
        self.counters["pings"] += 1
        return ping

    def _count_gap(self, delivered: tuple[int, int] | None, ping_number: int) -> None:
        """Count what the ping number tells: pings lost, or a sonar that started afresh."""
        ahead = 0 if delivered is None else (ping_number - delivered[0]) % 2**32
        if ahead > MAX_GAP:
            self.counters["ping_number_restarts"] += 1
        elif ahead > 1:
            self.counters["lost_pings"] += ahead - 1

    def _transmit_time(self, record: Record, delay_ns: int, map_time: TimeMap) -> tuple[int, int]:
        """Return local time and UTC of transmission; the record left the sonar `delay_ns` after it at the earliest."""
        if record.time_ns is None:
            self.counters["no_device_time"] += 1
            return record.first_ns - delay_ns, 0
        return map_time(record.time_ns + delay_ns, record.first_ns) - delay_ns, record.time_ns


class _Sonar:
    """What one sonar said last."""

    def __init__(self, map_time: TimeMap) -> None:
        self.map_time = map_time
        self.settings: deque[records.SonarSettings] = deque(maxlen=KEPT)
        self.tables: deque[tuple[int | None, BeamTable | None]] = deque(maxlen=KEPT)
        self.delivered: tuple[int, int] | None = None
        self._own_tables: deque[bool] = deque(maxlen=HABIT)
        """Whether the last pings had a beam table of their own."""

    def settings_of(self, data: WaterColumn) -> records.SonarSettings:
        for settings in reversed(self.settings):
            if (settings.ping_number, settings.multi_ping) == (data.ping_number, data.multi_ping):
                return settings
        raise RecordError("data_without_settings")

    def table_at(self, time_ns: int | None) -> BeamTable:
        """Return the beam table of the ping whose samples are of `time_ns`. Raises RecordError when it was lost."""
        owns = any(told_ns == time_ns for told_ns, _ in self.tables)
        lost = not owns and self._sends_with_each_ping()
        self._own_tables.append(owns)
        if lost or not self.tables:
            raise RecordError("data_without_geometry")
        return self._newest_table(time_ns)

    def _sends_with_each_ping(self) -> bool:
        known = len(self._own_tables)
        return known >= LEAST_HABIT and 2 * sum(self._own_tables) > known

    def _newest_table(self, time_ns: int | None) -> BeamTable:
        """Return the newest beam table that is not from a later ping. Raises RecordError when it was a bad one."""
        table = self.tables[-1][1]
        for told_ns, candidate in reversed(self.tables):
            if told_ns is None or time_ns is None or told_ns <= time_ns:
                table = candidate
                break
        if table is None:
            raise RecordError("data_without_geometry")
        return table


def _geometry(settings: records.SonarSettings, table: BeamTable, data: WaterColumn) -> Geometry:
    """Raises ValueError when the records do not fit each other."""
    if data.beam_numbers is not None:
        table = table.part(data.beam_numbers)
    dr_m = 0.5 * settings.sound_speed / (data.sample_rate_hz or settings.sample_rate_hz)
    return Geometry(
        table=table,
        range0_m=data.first_sample * dr_m,
        dr_m=dr_m,
        sound_speed=settings.sound_speed,
        frequency_hz=settings.frequency_hz,
        scale=data.scale,
        scale_factor=data.scale_factor,
    )
