"""Interface of every bridge: an encoder of lists, without any input or output."""

from typing import NamedTuple, Protocol

from ods.bridge.extrapolated_list import ExtrapolatedList


class Encoded(NamedTuple):
    """One list as datagrams."""

    datagrams: list[bytes]
    left_out: int
    """Obstacles that are known and in none of them."""


class Encoder(Protocol):
    """Turns lists into datagrams."""

    def encode(self, extrapolated: ExtrapolatedList) -> Encoded:
        """Return the datagrams of a list that is valid."""
