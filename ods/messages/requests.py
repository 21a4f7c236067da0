"""Requests to the sonar and to a replay, and their answers."""

from typing import Annotated, Literal

import msgspec

from ods.messages.fields import Count, ReplaySpeed, SonarLevel, SonarRange


class SonarRequest(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True):
    """A planner's request: these values apply until the next one; without any it is a query. Unknown fields are
    refused.

    The answer comes when the sonar reports the new value or the request has failed: allow some seconds.
    """

    range_m: SonarRange | None = None
    power_db: SonarLevel | None = None
    """dB re 1 uPa at 1 m."""
    gain_db: SonarLevel | None = None


class SonarAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """Result of a request."""

    ok: bool
    """The sonar uses the requested values."""
    reason: str
    range_m: float | None = None
    """As the sonar reports it now."""
    power_db: float | None = None
    gain_db: float | None = None


class ReplayRequest(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True):
    """Request to a live replay, `ods replay --live`."""

    do: Literal["tell", "pause", "go", "step"] = "tell"
    """`tell`: only the answer; `step`: continue for `steps` obstacle lists, then pause."""
    steps: Annotated[int, msgspec.Meta(ge=1, le=1_000_000)] = 1
    speed: ReplaySpeed | None = None
    """None: unchanged."""


class ReplayAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """State of a live replay after the request."""

    ok: bool
    reason: str
    paused: bool = False
    at_s: float = 0.0
    """Recording time of the newest message published."""
    speed: float = 1.0
    published: Count = 0
    """Messages so far."""
