"""Operators' vetoes, and the requests for them."""

from typing import Annotated, Literal

import msgspec

from ods.messages.fields import LARGEST_REGION_M, LONGEST_VETO_S, MOST_CORNERS, Coordinate, Count, Instant, ObjectId


class VetoRegion(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True):
    """A circle or a polygon in the local frame; it covers obstacles that lie entirely inside."""

    centre_ne: tuple[Coordinate, Coordinate] | None = None
    """Of a circle; none: a polygon."""
    radius_m: Annotated[float, msgspec.Meta(ge=0.0, le=LARGEST_REGION_M)] = 0.0
    corners_ne: Annotated[list[tuple[Coordinate, Coordinate]], msgspec.Meta(max_length=MOST_CORNERS)] = []
    """Of a polygon in order, at least three; empty: a circle."""
    down_m: tuple[Coordinate, Coordinate] | None = None
    """Interval of down coordinates that must contain an object's depth +- two sigmas. None: any."""

    def __post_init__(self) -> None:
        if (self.centre_ne is None) == (not self.corners_ne):
            raise ValueError("a region needs either `centre_ne` with `radius_m`, or `corners_ne`")
        if self.centre_ne is not None and not self.radius_m > 0.0:
            raise ValueError("radius_m: must be above 0")
        if self.corners_ne and (len(self.corners_ne) < 3 or self.radius_m):
            raise ValueError("corners_ne: a polygon has three corners or more, and no `radius_m`")
        spans = [max(axis) - min(axis) for axis in zip(*self.corners_ne, strict=True)]
        if spans and max(spans) > 2.0 * LARGEST_REGION_M:
            raise ValueError(f"corners_ne: more than {2.0 * LARGEST_REGION_M:g} m from north to south, or west to east")
        if self.down_m is not None and self.down_m[0] >= self.down_m[1]:
            raise ValueError("down_m: the second value must be greater than the first")


class Veto(msgspec.Struct, frozen=True, kw_only=True):
    """A veto in force: planners may ignore these obstacles."""

    number: Count
    """Counted by the tracker, from 0."""
    author: str
    """Name of the operator's key."""
    reason: str
    """The operator's."""
    until_ns: Instant
    """When it expires."""
    until_utc_ns: Instant
    region: VetoRegion
    """The obstacle is ignored only while its circle lies entirely inside. For a veto by id: its circle then, and 2 m
    around."""
    id: ObjectId | None = None
    """None: all static ones in the region (`moving` at most 0.5)."""


VetoAction = Literal["ignore", "forget", "restore", "list"]


class VetoRequest(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True):
    """An operator's request, on a socket that takes operators' keys only (`ods keys`)."""

    do: VetoAction
    """ignore: an obstacle by `id`, or static ones in a `region`, for `for_s`; forget: drop an obstacle by `id` until
    it echoes again; restore: end a veto by its `number`, or its obstacle's `id`; list: only the answer."""
    id: ObjectId | None = None
    region: VetoRegion | None = None
    number: Count | None = None
    reason: Annotated[str, msgspec.Meta(max_length=200)] = ""
    """The operator's; never empty, except with `list`."""
    for_s: Annotated[float, msgspec.Meta(gt=0.0, le=LONGEST_VETO_S)] | None = None
    """With `ignore` only."""

    def __post_init__(self) -> None:
        named = [name for name in ("id", "region", "number") if getattr(self, name) is not None]
        allowed = {"ignore": ("id", "region"), "forget": ("id",), "restore": ("id", "number"), "list": ()}[self.do]
        if len(named) != bool(allowed) or any(name not in allowed for name in named):
            raise ValueError(f"{self.do}: needs " + (f"one of {', '.join(allowed)}" if allowed else "nothing else"))
        if self.do != "list" and not self.reason.strip():
            raise ValueError("reason: missing")
        if not self.reason.isprintable():
            raise ValueError("reason: must be one line of plain text")
        if (self.for_s is None) == (self.do == "ignore"):
            raise ValueError("for_s: required by `ignore`, not allowed elsewhere")


class VetoAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """Result of a request."""

    ok: bool
    reason: str
    vetoes: list[Veto] = []
    """Those now in force."""


class VetoOrder(msgspec.Struct, frozen=True, kw_only=True):
    """A request as the tracker executed it; it applies to all later lists."""

    seq: Count
    t_ns: Instant
    """When it was executed or refused."""
    utc_ns: Instant
    author: str
    """Name of the operator's key."""
    request: VetoRequest
    refused: str
    """Why; empty: executed."""
