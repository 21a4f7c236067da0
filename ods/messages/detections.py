"""Detections of a ping, by the pipeline."""

from typing import Annotated, Literal

import msgspec

from ods.messages.fields import Angle, Count, CountOrNone, HearingLevel, Instant, Metres, SoundSpeed


class Detection(msgspec.Struct, frozen=True):
    """One echo: its circumscribed circle in the sonar's plane, a cylinder normal to it [SSIE]."""

    range_m: float
    """Slant range of the circle's centre."""
    bearing_rad: float
    radius_m: float
    peak: float
    """Highest equalized level, in multiples of the background."""
    mean: float
    """Mean equalized level."""
    snr_db: float
    """Peak over the local background."""
    cells: Count
    """Samples above the low threshold."""
    range_extent_m: float
    bearing_extent_rad: float
    sigma_range_m: float
    sigma_bearing_rad: float
    sigma_radius_m: float
    amplitude: float = 0.0
    """Peak raw sample."""
    elevation_rad: float = 0.0
    """Of the plane it was seen in."""
    near_m: float = 0.0
    """Slant range of the nearest point, far more accurate than the circle: errors of `range_m` and `radius_m` are
    correlated."""
    sigma_near_m: float = 0.0
    """0: not measured."""
    cut: bool = False
    """The echo reaches the border of the data: position and radius are of the visible part, with errors correlated
    from ping to ping."""
    onset: Annotated[float, msgspec.Meta(ge=0.0)] = 0.0
    """Rise of the leading edge from half level to peak, in widths of the point response: about 1 for an object, more
    for a bottom; 0: not measured."""
    front: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Probability that the leading edge is an object's and not a rough bottom's, if both are equally frequent; 0: not
    estimated."""
    half_length_m: float = 0.0
    """Half the visible length without the beam's width, of a uniform strip with the same second moments; 0: not
    measured."""
    half_width_m: float = 0.0
    """Half its width, likewise."""
    axis_rad: Angle = 0.0
    """Of the strip in the sonar's plane, from the line of sight to starboard, within +-pi/2."""
    elevation_extent_rad: float = 0.0
    """3-D sonar: visible vertical extent; 0: not measured."""
    sigma_elevation_rad: float = 0.0
    """0: the object is anywhere in the plane's opening."""


class Sector(msgspec.Struct, frozen=True, omit_defaults=True):
    """The limits of the fan in the frame of the sonar's head."""

    range_min_m: Metres
    range_max_m: Metres
    bearing_min_rad: Angle
    bearing_max_rad: Angle
    half_vertical_rad: Angle
    """Half the vertical opening of all planes."""
    plane_half_rad: Annotated[float, msgspec.Meta(ge=0.0, le=1.6)] = 0.0
    """The same of one of several; 0 (omitted): one plane, or not known."""


UnseenWhy = Literal["no data", "saturated", "level fallen", "level risen", "interference", "not swept"]


class UnseenPart(msgspec.Struct, frozen=True):
    """A part of the sector, in its frame, that a ping did not observe."""

    bearing_min_rad: Angle
    bearing_max_rad: Angle
    range_min_m: Metres
    range_max_m: Metres
    why: UnseenWhy
    """no data: dead beams, beams cut short, an empty image; saturated: full scale; level fallen: head blocked or out
    of the water; level risen: noise hides weaker objects; interference: beams with a continuous other source; not
    swept: a mechanically scanned head looked elsewhere."""


class LookedVolume(msgspec.Struct, frozen=True):
    """How far a 3-D sonar observed clear water in each direction, in the head's frame.

    Cells of equal angles over bearings and elevations. Nothing behind a cell's nearest echo was observed.
    """

    bearings: Annotated[int, msgspec.Meta(ge=1, le=256)]
    elevations: Annotated[int, msgspec.Meta(ge=1, le=256)]
    elevation_min_rad: Angle
    elevation_max_rad: Angle
    clear_m: bytes
    """C order (bearings, elevations), float32, little endian: slant range of the nearest echo, the bottom's too; else
    the sector's range. Weak echoes may be missing."""


class Detections(msgspec.Struct, frozen=True):
    """All detections of one ping; published even if there are none."""

    seq: Count
    """`Ping.seq`."""
    ping_number: Count
    t_ns: Instant
    t_rx_ns: Instant
    utc_ns: Instant
    sound_speed: SoundSpeed
    sector: Sector
    detections: list[Detection]
    usable: bool = True
    """False: the whole image is unusable (drop-out); a missing echo is no evidence."""
    processed_ranges_m: list[tuple[Metres, Metres]] = []
    """Slant ranges (from, to); empty: all."""
    unseen: list[UnseenPart] = []
    """What this ping did not observe."""
    unseen_share: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Of the image, or of what a mechanically scanned sonar looked at."""
    unseen_why: str = ""
    """Empty when all was seen, or only beams were not swept."""
    second_ways_m: list[float] = []
    """Additional slant ranges of multipath echoes."""
    caution: str = ""
    """Why a used image may be wrong."""
    poses_until: CountOrNone = -1
    """`Pose.seq` of the newest pose known; -1: none."""
    poses_heard: Count = 0
    """Poses published to this process since it started, lost ones too; 0: none, or not reported."""
    faint: list[Detection] = []
    """Weak detections, many of them false alarms: for users that combine many pings."""
    heard_from_db: HearingLevel | None = None
    """Detection threshold over the background, median of the image: 7 in open water, 9 to 11 over a smooth bottom,
    more over a rough one. Echoes with an object's leading edge may be detected below it."""
    turn_s: Annotated[float, msgspec.Meta(ge=0.0, le=1e4)] = 0.0
    """Of a mechanically scanned sonar's sweep; 0: each ping covers the sector."""
    looked_volume: LookedVolume | None = None
    """Of a 3-D sonar."""
