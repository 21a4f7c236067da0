"""Joins s7k records into pings: settings and beam geometry with the samples of the same ping. Pure.

What a ping says of itself comes from the records sent with it, so a change of range, sound speed or beams takes effect
at that very ping. A ping whose settings or geometry were lost is dropped and counted, never guessed.

A sonar may send its beam table with each ping or only when it changes. All records of one ping bear the same 7KTIME, so
a table with that of a ping's samples is the ping's own. Where most of the last HABIT pings had their own, one without
has lost it; else the table that was sent last holds.
"""

from collections import Counter, deque

import msgspec

from ods.messages import Ping
from ods.sonar_link.ping_builder import BeamTable, Geometry, Stamp, build_ping, listening_ns
from ods.sonar_link.ping_numbers import PingNumbers
from ods.sonar_link.s7k import records
from ods.sonar_link.s7k.drf import DeviceId, S7kRecord
from ods.sonar_link.s7k.loss import Loss, RecordError
from ods.sonar_link.s7k.water_column import WaterColumn

KEPT = 4
"""Settings and beam tables kept of each sonar: a sonar may announce the next ping before this one's samples are out."""
HABIT = 8
"""Number of pings by which a sonar's way to send beam tables is recognized."""
LEAST_HABIT = 4
"""Fewer pings show nothing: a sonar may announce its beams more than once at its start."""
MAX_SONARS = 8


class Assembler:
    """Takes records in the order of their arrival and returns pings, each at its transmission in the sonar's own time.

    Counters: pings; lost_pings (numbers that never became a ping, for whatever reason), duplicate_pings,
    ping_number_restarts; data_without_settings, data_without_geometry; bad_settings, bad_beam_table, bad_water_column,
    unsupported_layout, bad_ping (records that do not fit each other); other_records; no_device_time.
    """

    def __init__(self, counters: "Counter[str] | None" = None) -> None:
        self.counters: Counter[str] = Counter() if counters is None else counters
        self._sonars: dict[DeviceId, _Sonar] = {}
        self._seq = 0

    def feed(self, record: S7kRecord, content: records.Content | Loss | None) -> Ping | None:
        """Take one record with what `records.decode` says of it; return the ping that it completes.

        A record without a time makes a ping at its arrival, less the time that the sonar listened.
        """
        sonar = self._sonar(record)
        if isinstance(content, Loss):
            self.counters[content.value] += 1
            if record.record_type == records.BEAM_GEOMETRY:
                sonar.tables.append((record.time_ns, None))  # its ping must not get an older table
        elif isinstance(content, WaterColumn):
            try:
                return self._complete(record, content, sonar)
            except RecordError as error:
                self.counters[error.loss.value] += 1
        elif isinstance(content, BeamTable):
            sonar.tables.append((record.time_ns, content))
        elif content is not None:
            sonar.settings.append(content)
        else:
            self.counters["other_records"] += 1
        return None

    def _sonar(self, record: S7kRecord) -> "_Sonar":
        if record.device not in self._sonars:
            if len(self._sonars) >= MAX_SONARS:
                self._sonars.clear()
            self._sonars[record.device] = _Sonar(PingNumbers(self.counters))
        return self._sonars[record.device]

    def _complete(self, record: S7kRecord, data: WaterColumn, sonar: "_Sonar") -> Ping:
        this = data.ping_number, data.multi_ping, record.time_ns
        if sonar.delivered == this:
            raise RecordError(Loss.DUPLICATE_PING)
        settings = sonar.settings_of(data)
        table = sonar.table_at(record.time_ns)
        sent_ns = record.time_ns or 0
        stamp = Stamp(self._seq, data.ping_number, sent_ns, record.last_ns, sent_ns)
        try:
            ping = build_ping(data.frame, _geometry(settings, table, data), stamp, data.no_data)
            ping = msgspec.structs.replace(ping, setting=settings.controls.levels())
        except ValueError:
            raise RecordError(Loss.BAD_PING) from None
        if record.time_ns is None:
            self.counters["no_device_time"] += 1
            ping = msgspec.structs.replace(ping, t_ns=record.first_ns - listening_ns(ping))
        sonar.numbers.follow(data.ping_number)
        sonar.delivered = this
        self._seq += 1
        self.counters["pings"] += 1
        return ping


class _Sonar:
    """What one sonar said last."""

    def __init__(self, numbers: PingNumbers) -> None:
        self.numbers = numbers
        self.settings: deque[records.SettingsRecord] = deque(maxlen=KEPT)
        self.tables: deque[tuple[int | None, BeamTable | None]] = deque(maxlen=KEPT)
        self.delivered: tuple[int, int, int | None] | None = None
        """Number, part and 7KTIME of the newest ping; of a sonar that does not number its pings the times differ."""
        self._own_tables: deque[bool] = deque(maxlen=HABIT)
        """Whether the last pings had a beam table of their own."""

    def settings_of(self, data: WaterColumn) -> records.SettingsRecord:
        for settings in reversed(self.settings):
            if (settings.ping_number, settings.multi_ping) == (data.ping_number, data.multi_ping):
                return settings
        raise RecordError(Loss.DATA_WITHOUT_SETTINGS)

    def table_at(self, time_ns: int | None) -> BeamTable:
        """Return the beam table of the ping whose samples are of `time_ns`. Raises RecordError when it was lost."""
        owns = any(sent_ns == time_ns for sent_ns, _ in self.tables)
        lost = not owns and self._sends_with_each_ping()
        self._own_tables.append(owns)
        if lost or not self.tables:
            raise RecordError(Loss.DATA_WITHOUT_GEOMETRY)
        return self._newest_table(time_ns)

    def _sends_with_each_ping(self) -> bool:
        known = len(self._own_tables)
        return known >= LEAST_HABIT and 2 * sum(self._own_tables) > known

    def _newest_table(self, time_ns: int | None) -> BeamTable:
        """Return the newest beam table that is not from a later ping. Raises RecordError when it was a bad one."""
        table = self.tables[-1][1]
        for sent_ns, candidate in reversed(self.tables):
            if sent_ns is None or time_ns is None or sent_ns <= time_ns:
                table = candidate
                break
        if table is None:
            raise RecordError(Loss.DATA_WITHOUT_GEOMETRY)
        return table


def _geometry(settings: records.SettingsRecord, table: BeamTable, data: WaterColumn) -> Geometry:
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
