"""Settings of the s7k protocol."""

from typing import Literal

from ods.base.settings import Settings


class S7kSettings(Settings, frozen=True):
    """What only a sonar of the RESON 7k Data Format has."""

    samples_record: Literal[7042, 7018] = 7042
    """The record of the samples that is asked for over tcp://, beside 7000 and 7004; a serial line sends what it is
    set to, and both are read from it."""
