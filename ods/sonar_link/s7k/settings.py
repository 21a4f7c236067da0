"""Settings of the s7k protocol."""

from typing import Literal

from ods.base.settings import Settings


class S7kSettings(Settings, frozen=True):
    """RESON 7k Data Format."""

    samples_record: Literal[7042, 7018] = 7042
    """Samples subscribed to over tcp://; on a serial line both are read."""
