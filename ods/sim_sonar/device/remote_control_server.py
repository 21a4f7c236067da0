"""The simulated sonar's remote control: reads requests from the line, applies or refuses them, and answers."""

from typing import Protocol

from ods.sim_sonar.sonar.model import SonarModel
from ods.sonar_link.s7k import drf, records, remote_control
from ods.sonar_link.s7k.drf import S7kRecord
from ods.sonar_link.s7k.framer import RecordFramer
from ods.sonar_link.s7k.loss import RecordError
from ods.sonar_link.s7k.remote_control import ControlRequest
from ods.sonar_link.setting_requests import Controls

NOMINAL_POWER_DB, NOMINAL_GAIN_DB = 210.0, 30.0
"""Those of the scene's levels, and those after switching on."""
POWERS_DB, GAINS_DB = (170.0, 220.0), (0.0, 83.0)
LEAST_RANGE_M = 5.0
MAX_RECORD_REQUEST_BYTES = 4096
REPLY_PATIENCE_S = 0.01
UNKNOWN_COMMAND, OUT_OF_LIMITS = 1, 2
"""Error codes of this simulator; those of real sonars are not known."""


class Line(Protocol):
    """A line that carries the records: SerialLine or TcpLine."""

    lost_bytes: int
    needs_subscription: bool
    """False: everything is sent, asked for or not."""
    connections: int
    """Clients that there have been."""

    def plug(self) -> None:
        """Make the line appear."""

    def unplug(self) -> None:
        """Make it vanish."""

    def write(self, records: list[bytes], patience_s: float) -> bool:
        """Send records; return whether all of them went out in time."""

    def read(self) -> bytes:
        """Return the bytes of records that have come."""


class RemoteControlServer:
    """The requested settings of the sonar, and the records to which a client has subscribed."""

    def __init__(self, sonar: SonarModel, line: Line) -> None:
        """The sonar's file reports the longest range, which is that after switching on."""
        self._line = line
        self._ranges_m = LEAST_RANGE_M, sonar.range0_m + (sonar.samples - 1) * sonar.dr_m
        self.controls = Controls(self._ranges_m[1], NOMINAL_POWER_DB, NOMINAL_GAIN_DB)
        self._framer = RecordFramer(MAX_RECORD_REQUEST_BYTES)
        self._subscribed: set[int] = set()
        self._client = 0

    def listen(self, utc_ns: int) -> None:
        """Apply received requests; the replies are stamped `utc_ns`."""
        records = self._framer.feed(self._line.read())
        if self._line.connections != self._client:
            self._client = self._line.connections
            self._subscribed = set()
        for record in records:
            self._take(record, utc_ns)

    def wanted(self, records: list[bytes]) -> list[bytes]:
        """Return those of a ping's records that go out: all on a serial line, over TCP those subscribed to."""
        if not self._line.needs_subscription:
            return records
        return [record for record in records if drf.unpack_record_header(record).record_type in self._subscribed]

    def _take(self, record: S7kRecord, utc_ns: int) -> None:
        if record.record_type != remote_control.REMOTE_CONTROL:
            return
        try:
            request = remote_control.decode_request(record)
            error = self._obey(request)
        except RecordError:
            return
        reply = remote_control.encode_reply(request, error, utc_ns, records.DEVICE)
        self._line.write([reply], REPLY_PATIENCE_S)

    def _obey(self, request: ControlRequest) -> int | None:
        """Return the error, None when obeyed. Raises RecordError."""
        now = self.controls
        if request.command == remote_control.SUBSCRIBE:
            self._subscribed = remote_control.subscribed_types(request)
            return None
        limits = {
            remote_control.SET_RANGE: self._ranges_m,
            remote_control.SET_POWER: POWERS_DB,
            remote_control.SET_GAIN: GAINS_DB,
        }.get(request.command)
        if limits is None:
            return UNKNOWN_COMMAND
        value = remote_control.value_of(request)
        if not limits[0] <= value <= limits[1]:
            return OUT_OF_LIMITS
        self.controls = Controls(
            value if request.command == remote_control.SET_RANGE else now.range_m,
            value if request.command == remote_control.SET_POWER else now.power_db,
            value if request.command == remote_control.SET_GAIN else now.gain_db,
        )
        return None
