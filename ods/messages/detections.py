"""Detections of a ping, by the pipeline."""

from typing import Annotated, Literal

import msgspec

from ods.messages.fields import Angle, Count, CountOrNone, HearingLevel, Instant, Metres, SoundSpeed


class Detection(msgspec.Struct, frozen=True):
    """One echo: the circle that circumscribes it in the sonar's plane, standing for a cylinder normal to it [SSIE]."""

    range_m: float
    """Slant range of the circle's centre."""
    bearing_rad: float
    radius_m: float
    peak: float
    """Highest equalized level inside, in multiples of the background."""
    mean: float
    """Mean equalized level inside, in multiples of the background."""
    snr_db: float
    """Peak over the local background."""
    cells: Count
    """Number of samples above the low threshold."""
    range_extent_m: float
    bearing_extent_rad: float
    sigma_range_m: float
    sigma_bearing_rad: float
    sigma_radius_m: float
    amplitude: float = 0.0
    """Peak raw sample, as recorded."""
    elevation_rad: float = 0.0
    """Elevation of the plane it was seen in."""
    near_m: float = 0.0
    """Slant range of the object's nearest point. It is far more accurate than the circle, of which an echo may show the
    front only: the errors of `range_m` and `radius_m` are correlated."""
    sigma_near_m: float = 0.0
    """Standard deviation of `near_m`; 0: not measured, as in older recordings."""
    cut: bool = False
    """The echo reaches the first or last beam, beams without data, or the nearest or farthest range. The object may
    extend beyond; position and radius are those of its visible part. Their errors are then correlated from ping to
    ping."""
    onset: Annotated[float, msgspec.Meta(ge=0.0)] = 0.0
    """Rise: distance from the half-level point of the leading edge to the peak, in widths of the point response. About
    1 for the face of an object, more for a bottom whose level rises slowly; 0: not measured."""
    front: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Probability that the leading edge is an object's and not a crest's of a rough bottom, if both are equally
    frequent; 0: not estimated, as in calm water."""
    half_length_m: float = 0.0
    """Half the length of what is seen, along its long axis, with the beam's width taken out: of a uniform strip with
    the same second moments. 0: not measured, as in older recordings."""
    half_width_m: float = 0.0
    """Half its width, likewise."""
    axis_rad: Angle = 0.0
    """Direction of the long axis in the sonar's plane, from the line of sight to starboard, within +-pi/2."""
    elevation_extent_rad: float = 0.0
    """Of a 3-D sonar: vertical extent of what is seen of the object, around `elevation_rad`; 0: not measured."""
    sigma_elevation_rad: float = 0.0
    """Standard deviation of `elevation_rad`; 0: not measured, the object is anywhere in the plane's opening."""


class Sector(msgspec.Struct, frozen=True, omit_defaults=True):
    """The region that a ping covers: the limits of the fan in the frame of the sonar's head."""

    range_min_m: Metres
    range_max_m: Metres
    bearing_min_rad: Angle
    bearing_max_rad: Angle
    half_vertical_rad: Angle
    """Half the vertical opening, of all planes together."""
    plane_half_rad: Annotated[float, msgspec.Meta(ge=0.0, le=1.6)] = 0.0
    """Half the vertical opening of one of several planes; 0, and then omitted: there is one plane, or it is not
    known."""


UnseenWhy = Literal["no data", "saturated", "level fallen", "level risen", "interference", "not swept"]


class UnseenPart(msgspec.Struct, frozen=True):
    """A part of the sector that a ping did not observe, in the frame of the sonar's head."""

    bearing_min_rad: Angle
    bearing_max_rad: Angle
    range_min_m: Metres
    range_max_m: Metres
    why: UnseenWhy
    """no data: there are no samples (dead beams, beams cut short, an empty image); saturated: samples are at full
    scale; level fallen: levels are far below those before (the head is blocked or out of the water); level risen:
    levels at all ranges jumped (noise hides weaker objects); interference: beams with a continuous other source; not
    swept: the head of a mechanically scanned sonar looked elsewhere."""


class LookedVolume(msgspec.Struct, frozen=True):
    """Of a 3-D sonar: how far the water is clear in each direction, in the frame of the sonar's head.

    Cells of equal angles: `bearings` of them over the sector's bearings, `elevations` over the elevations. What lies
    behind the nearest echo of a cell was not observed.
    """

    bearings: Annotated[int, msgspec.Meta(ge=1, le=256)]
    elevations: Annotated[int, msgspec.Meta(ge=1, le=256)]
    elevation_min_rad: Angle
    elevation_max_rad: Angle
    clear_m: bytes
    """C order (bearings, elevations), float32, little endian: slant range of the nearest echo, the bottom's too; the
    sector's largest range where there is none. Weak echoes may be missing: a pixel holds its strongest one only."""


class Detections(msgspec.Struct, frozen=True):
    """All detections of one ping; published for pings without detections, too."""

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
    """False if the whole image is unusable (drop-out): a missing echo is then no evidence."""
    processed_ranges_m: list[tuple[Metres, Metres]] = []
    """Slant ranges (from, to) that were processed; empty: all. Elsewhere a missing echo is no evidence."""
    unseen: list[UnseenPart] = []
    """Parts of the sector that this ping did not observe: there a missing echo is no evidence."""
    unseen_share: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Their share of the image, or of a mechanically scanned sonar of the part that the ping looked at."""
    unseen_why: str = ""
    """Why, in plain words; empty when all was seen, or when only beams were not swept."""
    second_ways_m: list[float] = []
    """Multipath: additional path lengths, m of slant range, at which echoes repeat; empty: none is known."""
    caution: str = ""
    """Why an image that is used may be wrong, in plain words, such as that it does not change; empty: no reason."""
    poses_until: CountOrNone = -1
    """`Pose.seq` of the newest pose that the pipeline knew when it worked on the ping; -1: none. With the same poses,
    the same ping gives the same detections."""
    poses_heard: Count = 0
    """Number of poses published to it since it started, some of which it may have lost; 0: none, or not reported."""
    faint: list[Detection] = []
    """Weak detections, below the threshold for the wanted false-alarm rate; many are false alarms. For users that
    combine many pings, as the tracker does."""
    heard_from_db: HearingLevel | None = None
    """Detection threshold over the background, dB, median of the image: 7 in open water, 9 to 11 over a smooth bottom,
    more where crests of the bottom are strong. Echoes with an object's leading edge may be detected below it. None: no
    part of the image was processed, or the detector does not report it."""
    turn_s: Annotated[float, msgspec.Meta(ge=0.0, le=1e4)] = 0.0
    """Time in which a mechanically scanned sonar looks at all of its sector once; 0: each ping does."""
    looked_volume: LookedVolume | None = None
    """How far the water is clear by bearing and elevation; none: the sonar has no range image."""
