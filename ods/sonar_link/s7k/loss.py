"""Why something that came from a 7k sonar cannot be used."""

from enum import Enum


class Loss(Enum):
    """Each is counted in the counter of its value."""

    BAD_VERSION = "bad_version"
    BAD_OFFSET = "bad_offset"
    SHORT_RECORD = "short_record"
    OVERLONG_RECORD = "overlong_record"
    BAD_CHECKSUM = "bad_checksum"
    TRUNCATED_RECORD = "truncated_record"
    NESTED_RECORD = "nested_record"
    BAD_SETTINGS = "bad_settings"
    BAD_BEAM_TABLE = "bad_beam_table"
    BAD_WATER_COLUMN = "bad_water_column"
    UNSUPPORTED_LAYOUT = "unsupported_layout"
    BAD_REMOTE_CONTROL = "bad_remote_control"
    DATA_WITHOUT_SETTINGS = "data_without_settings"
    DATA_WITHOUT_GEOMETRY = "data_without_geometry"
    DUPLICATE_PING = "duplicate_pings"
    BAD_PING = "bad_ping"


class RecordError(Exception):
    """A record that cannot be used."""

    def __init__(self, loss: Loss) -> None:
        super().__init__(loss.value)
        self.loss = loss
