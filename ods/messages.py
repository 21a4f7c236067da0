"""Everything that travels between processes: msgspec structs, msgpack maps on the wire.

Conventions: angles in radians, SI units, world frame NED, body frame FRD, bearing positive to starboard,
elevation positive up. `t_ns` is CLOCK_MONOTONIC of this machine, `utc_ns` is nanoseconds since 1970 (UTC).
On another machine only UTC means anything. Fields whose name ends in `_ns` are integers of 64 bits, and the only ones
that may exceed 2^53: as JavaScript's Number, UTC is rounded to 256 ns; ask the decoder for BigInt where that matters
(`useBigInt64` of @msgpack/msgpack). New ids are below 2^31.
The reference in docs/messages.md is generated from these types.
"""

from typing import TYPE_CHECKING, Annotated, Literal

import msgspec

if TYPE_CHECKING:
    from ods.base.arrays import AnyArray  # a planner's computer need not have numpy

Vector3 = tuple[float, float, float]
Instant = Annotated[int, msgspec.Meta(ge=-(2**62), le=2**62)]
"""ns."""
Angle = Annotated[float, msgspec.Meta(ge=-6.3, le=6.3)]
"""rad: a turn, either way."""
Metres = Annotated[float, msgspec.Meta(ge=-1e5, le=1e5)]
"""Of a sonar."""
Coordinate = Annotated[float, msgspec.Meta(ge=-1e7, le=1e7)]
"""m; the earth is no larger."""
SoundSpeed = Annotated[float, msgspec.Meta(ge=0.0, le=1e4)]
"""m/s; 0: not reported."""
Coordinates = tuple[Coordinate, Coordinate, Coordinate]
Speed = Annotated[float, msgspec.Meta(ge=-1e3, le=1e3)]
"""m/s."""
Velocity = tuple[Speed, Speed, Speed]
Uncertainty = Annotated[float, msgspec.Meta(ge=-1e3, le=1e3)]
"""rad; what is below 0 is a bad pose."""
ObjectId = Annotated[int, msgspec.Meta(ge=-(2**53), le=2**53)]
"""New ones are below 2^31."""
Height = Annotated[float, msgspec.Meta(ge=0.0, le=2e4)]
"""m, over the bottom; no sea is deeper."""
Part = Annotated[float, msgspec.Meta(ge=-2.0, le=2.0)]
"""Of a unit quaternion."""
Quaternion = tuple[float, float, float, float]
Scale = Literal["linear", "db", "log8"]
SampleType = Literal["u1", "u2", "f4"]
UtcSource = Literal["clock", "ins", "unsure"]
"""Source of the UTC in a message: this computer's clock, the INS's, or an unreliable one."""
Count = Annotated[int, msgspec.Meta(ge=0)]
CountOrNone = Annotated[int, msgspec.Meta(ge=-1)]
"""-1: none."""
SonarRange = Annotated[float, msgspec.Meta(ge=0.1, le=20_000.0)]
"""What a sonar can be asked for, m."""
MOST_HEARING_DB = 200.0
HearingLevel = Annotated[float, msgspec.Meta(ge=0.0, le=MOST_HEARING_DB)]
"""Over the background, dB."""
SonarLevel = Annotated[float, msgspec.Meta(ge=-200.0, le=300.0)]
"""Power and gain that a sonar can be asked for, dB."""

MOST_CORNERS = 16
LARGEST_REGION_M = 100.0
LONGEST_VETO_S = 14_400.0

ReplaySpeed = Annotated[float, msgspec.Meta(ge=0.01, le=100.0)]
"""Seconds of a recording in a second."""


class RangeGrid(msgspec.Struct, frozen=True):
    """Marks a ping as a range image: each direction has the range of its strongest echo, not a level at each range.

    Column k of `Ping.data` has the elevation `elevation_rad[k]`. `Ping.dr_m` times the number of a pixel is the slant
    range, m; 0: no echo in that direction.
    """

    elevation_rad: list[Angle]
    """(samples,) strictly increasing, up positive."""
    range_max_m: Annotated[float, msgspec.Meta(gt=0.0, le=1e5)]
    """Up to this range an echo would have been received."""


class Sweep(msgspec.Struct, frozen=True):
    """How a mechanically scanned head, which looks one beam at a time, goes over its sector."""

    bearing_min_rad: Angle
    """The sector, from the middle of its first beam"""
    bearing_max_rad: Angle
    """to that of its last one."""
    step_rad: Angle
    """From beam to beam."""
    turn_s: Annotated[float, msgspec.Meta(ge=0.0, le=1e4)]
    """Time in which it goes over all of it once."""
    rising: bool
    """It turns to starboard."""
    ends: bool = False
    """The next beam does not go on from the last one of this ping: the head turns back, or jumps."""


class Ping(msgspec.Struct, frozen=True):
    """One sonar image with its own geometry, or of a mechanically scanned sonar some beams that follow each other.

    Planes of a multi-plane sonar are stacked: row `p * beams_per_plane + b`, `beams` counts all rows.
    """

    seq: Count
    """Pings published by this sonar process, from 0."""
    ping_number: Count
    """The sonar's own ping counter."""
    t_ns: Instant
    """Transmit time."""
    t_rx_ns: Instant
    """When the last byte of this ping was read."""
    utc_ns: Instant
    """Transmit time, UTC."""
    beams: Annotated[int, msgspec.Meta(ge=1, le=4096)]
    samples: Annotated[int, msgspec.Meta(ge=1, le=65536)]
    dtype: SampleType
    """Sample type of `data`, little endian: u1 uint8, u2 uint16, f4 float32."""
    data: bytes
    """Amplitudes, C order (beams, samples)."""
    bearing_rad: list[Angle]
    """(beams,) true bearing of each beam, strictly increasing within a plane."""
    range0_m: Metres
    """Slant range of the first sample's centre."""
    dr_m: Annotated[float, msgspec.Meta(ge=1e-6, le=100.0)]
    """Sample spacing in slant range."""
    sound_speed: SoundSpeed
    """m/s."""
    elevation_rad: list[Angle] = []
    """(beams,) elevation of each beam; empty when all are 0."""
    beam_width_rad: list[Angle] = []
    """(beams,) horizontal -3 dB width of each beam; empty if not reported."""
    planes: Annotated[int, msgspec.Meta(ge=1, le=64)] = 1
    frequency_hz: Annotated[float, msgspec.Meta(ge=0.0, le=1e9)] = 0.0
    """0 if not reported."""
    scale: Scale = "linear"
    """linear: proportional to pressure amplitude; db: decibels; log8: a = scale_factor * log10(linear)."""
    scale_factor: Annotated[float, msgspec.Meta(ge=-1e9, le=1e9)] = 1.0
    """log8: the factor F (s7k record 7042, default 40); db: decibels a count; linear: unused."""
    setting: str = ""
    """Other settings of the sonar, such as power and gain. Levels of pings with different settings are not
    comparable."""
    no_data: list[tuple[int, int, int]] = []
    """Samples without data, as runs (beam, first, stop): samples `first` to `stop` - 1 of that beam. Empty: the sonar
    reports no such samples."""
    beam_t_ns: list[Instant] = []
    """(beams,) transmit time of each beam of a mechanically scanned sonar, `t_ns` that of the newest; empty: all were
    transmitted at `t_ns`."""
    sweep: Sweep | None = None
    """Of a mechanically scanned sonar, whose ping has beams over 50 degrees at most; none: the ping is an image of all
    of the sector."""
    range_grid: RangeGrid | None = None
    """Of a 3-D sonar: `data` are ranges by bearing and elevation. None: levels by bearing and range."""


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
    """Peak over the local background, dB."""
    cells: Count
    """Number of samples above the low threshold."""
    range_extent_m: float
    bearing_extent_rad: float
    sigma_range_m: float
    """Standard deviation of `range_m`."""
    sigma_bearing_rad: float
    """Standard deviation of `bearing_rad`."""
    sigma_radius_m: float
    """Standard deviation of `radius_m`."""
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
    sector's largest range where there is none. Weak echoes may be missing: a pixel tells its strongest one only."""


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
    """Slant ranges (from, to) that were processed, m; empty: all. Elsewhere a missing echo is no evidence."""
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


class Pose(msgspec.Struct, frozen=True):
    """The pose of the vehicle's origin as its own navigation filter reports it."""

    seq: Count
    t_ns: Instant
    utc_ns: Instant
    position_ned: Coordinates
    attitude: tuple[Part, Part, Part, Part]
    """w, x, y, z; body to global."""
    velocity_body: Velocity
    """FRD, m/s."""
    sigma_position_ned: Coordinates
    """Standard deviations, m."""
    sigma_attitude: tuple[Uncertainty, Uncertainty, Uncertainty]
    """Standard deviations of roll, pitch, yaw, rad."""
    utc_source: UtcSource = "unsure"
    """Source of `utc_ns`: this computer's clock, the INS's, or an unreliable one."""
    altitude_m: Height | None = None
    """Altitude of the vehicle's origin over the bottom straight below; none: not reported, or implausible."""
    sigma_altitude_m: Coordinate = 0.0
    """Its standard deviation, m."""


TrackState = Literal["active", "stand_by", "hibernated", "terminated"]


class ClosestApproach(msgspec.Struct, frozen=True, gc=False):
    """Closest point of approach of an obstacle if it and the vehicle keep their velocities.

    In the horizontal plane, and to the obstacle's edge: its depth is hardly observed, so it stands for a vertical
    cylinder. The vehicle is a point, its origin.
    """

    time_s: float
    """Time after the list's `t_ns`, within [0, `tracker.planner.approach_horizon_s`]. 0: the distance is smallest now,
    as it grows or stays the same (parallel courses, both static)."""
    distance_m: float
    """Between the vehicle's origin and the obstacle's edge at that time; below 0: inside it."""
    sigma_m: float
    """Standard deviation of `distance_m`, from the obstacle's position at that time and its radius, or, if that is
    larger, from the effect of its velocity's error on the time: an object that seems to fall behind may approach."""


class Prediction(msgspec.Struct, frozen=True, gc=False):
    """Where an obstacle will be if it keeps its velocity."""

    lead_s: float
    """Time from the list's `t_ns`."""
    position_ned: Vector3
    sigma_position: Vector3
    """Standard deviations, m, north east down: they grow with the uncertainty of its velocity and by what manoeuvres
    may add."""


class Outline(msgspec.Struct, frozen=True, gc=False):
    """The strip that stands for an elongated object, as far as it is visible, in the horizontal plane."""

    middle_ne: tuple[float, float]
    """North and east of its middle, m; its standard deviations are those of the obstacle's position."""
    half_length_m: float
    half_width_m: float
    azimuth_rad: float
    """Direction of its long axis, from north to east, within [0, pi)."""
    sigma_half_length_m: float


class Obstacle(msgspec.Struct, frozen=True):
    """One tracked object [SSIE figure 5]."""

    id: ObjectId
    state: TrackState
    position_ned: Vector3
    velocity_ned: Vector3
    radius_m: float
    sigma_position: Vector3
    """Standard deviations, m, north east down."""
    sigma_velocity: Vector3
    """Standard deviations, m/s, north east down. For a static object: the largest velocity that its echoes do not
    exclude yet."""
    sigma_radius: float
    first_seen_utc_ns: int
    last_seen_utc_ns: int
    times_seen: Count
    existence: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
    """Probability that the object exists."""
    covariance_ne: float = 0.0
    """Covariance of north and east position, m^2: with `sigma_position` the error ellipse."""
    cpa: ClosestApproach | None = None
    """Closest point of approach; none when the vehicle's pose is not known at `t_ns`, and for terminated objects."""
    predicted: list[Prediction] = []
    """At each of `tracker.planner.lead_times_s`; empty for terminated objects."""
    unseen_s: Annotated[float, msgspec.Meta(ge=0.0)] = 0.0
    """Part of the time since it was last seen in which its position was not observed, s: the object is coasted, not
    missed."""
    bottom_probability: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Probability that it is part of the bottom, reaching no higher over it than `tracker.bottom.clearance_m`. 0 if the
    bottom is not known, as the pose has no altitude."""
    height_above_bottom_m: float | None = None
    """Height of the middle of its visible part over the bottom; none: the bottom is not known."""
    sigma_height_above_bottom_m: float | None = None
    """Its standard deviation, m: large where heights are not observed, as with a sonar of one plane."""
    moving: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Probability that it moves."""
    multipath_of: CountOrNone = -1
    """Id of the obstacle of which this one is probably a multipath echo (`Detections.second_ways_m`); -1: no sign of
    that. It stays in the list, as there may be an object."""
    near_m: float | None = None
    """Slant range from the sonar's head to the object's nearest point. It is more accurate than position and radius,
    whose errors are correlated. None: it was not seen for more than 2 s, its echoes have no near
    edge, or the list is not of a ping."""
    sigma_near_m: float | None = None
    """Standard deviation of `near_m`."""
    elongated: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Probability that it is an elongated object (a wall, a net, a rope): longer than 3 m, and than 4 times its
    width."""
    outline: Outline | None = None
    """Its outline, where `elongated` exceeds 0.9, within the circle of `radius_m`. None: the circle describes it."""
    ignored_by: CountOrNone = -1
    """`Veto.number` of the operator's veto by which a planner may ignore it (`ObstacleList.vetoes`); -1: none."""


class VetoRegion(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True):
    """A region that a veto names: a circle or a polygon, in the local frame. Only what lies whole inside is meant."""

    centre_ne: tuple[Coordinate, Coordinate] | None = None
    """North and east of the circle's centre, m; none: a polygon."""
    radius_m: Annotated[float, msgspec.Meta(ge=0.0, le=LARGEST_REGION_M)] = 0.0
    corners_ne: Annotated[list[tuple[Coordinate, Coordinate]], msgspec.Meta(max_length=MOST_CORNERS)] = []
    """North and east of the polygon's corners in order, m, at least three; empty: a circle."""
    down_m: tuple[Coordinate, Coordinate] | None = None
    """From and to this depth in the local frame, down positive, m, where lists have depths: an object is meant only if
    two standard deviations of its depth fit, too. None: at any depth."""

    def __post_init__(self) -> None:
        if (self.centre_ne is None) == (not self.corners_ne):
            raise ValueError("a region is either `centre_ne` with `radius_m` or `corners_ne`")
        if self.centre_ne is not None and not self.radius_m > 0.0:
            raise ValueError("radius_m: must be above 0")
        if self.corners_ne and (len(self.corners_ne) < 3 or self.radius_m):
            raise ValueError("corners_ne: a polygon has three corners or more, and no `radius_m`")
        spans = [max(axis) - min(axis) for axis in zip(*self.corners_ne, strict=True)]
        if spans and max(spans) > 2.0 * LARGEST_REGION_M:
            raise ValueError(f"corners_ne: more than {2.0 * LARGEST_REGION_M:g} m from north to south, or west to east")
        if self.down_m is not None and self.down_m[0] >= self.down_m[1]:
            raise ValueError("down_m: must grow")


class Veto(msgspec.Struct, frozen=True, kw_only=True):
    """An operator's veto that holds: he says that obstacles are to be ignored."""

    number: Count
    """Counted by the tracker, from 0."""
    author: str
    """Name of the key by which it came (`ods keys`)."""
    reason: str
    until_ns: Instant
    """When it expires, CLOCK_MONOTONIC, so that a step of UTC changes nothing,"""
    until_utc_ns: Instant
    """and the same, UTC."""
    region: VetoRegion
    """The obstacle is ignored only while its circle, of `radius_m`, lies whole inside. Of a veto by id: the circle that
    it had then, and 2 m around."""
    id: ObjectId | None = None
    """The obstacle; none: all that are at rest in the region, `moving` at most 0.5."""


class Site(msgspec.Struct, frozen=True):
    """The origin of the local frame, on the ellipsoid of WGS 84 (height 0): its plane touches there."""

    latitude_deg: Annotated[float, msgspec.Meta(ge=-90.0, le=90.0)]
    longitude_deg: Annotated[float, msgspec.Meta(ge=-180.0, le=180.0)]


class PoseAt(msgspec.Struct, frozen=True):
    """The pose of the vehicle's origin, or of the sonar's head, at one instant: from `Pose`s, by interpolation."""

    position_ned: Vector3
    attitude: Quaternion
    """w, x, y, z; body, or head, to global."""
    velocity_ned: Vector3
    """Of the vehicle's origin, m/s."""
    sigma_position: Vector3
    """Standard deviations, m, north east down."""
    sigma_attitude: Vector3
    """Standard deviations of the vehicle's roll, pitch, yaw, rad."""
    extrapolated_s: float = 0.0
    """Time to the `Pose` from which it was extrapolated, s; 0: it lies between two."""


class ObstacleList(msgspec.Struct, frozen=True):
    """The complete list of obstacles for the path planner, at every ping and at least twice a second."""

    seq: Count
    """Lists published by this tracker process, from 0."""
    ping_number: int
    """Number of the ping of this list; -1: a list without a ping, which is not valid."""
    t_ns: int
    """Time to which the list refers: transmit time of the ping, or now if there was none."""
    utc_ns: int
    t_rx_ns: int
    """When the ping's last byte was read; 0 when there was none."""
    valid: bool
    """False: the list may be incomplete or wrong; `reasons` says why."""
    reasons: list[str]
    obstacles: list[Obstacle]
    utc_source: UtcSource = "unsure"
    """Source of the UTC of the list and its obstacles: this computer's clock, the INS's, or an unreliable one. The
    list's validity does not depend on it."""
    left_out: Count = 0
    """Number of objects omitted from the list, as `tracker.planner.most_listed` others are nearer."""
    bottom_left_out: Count = 0
    """Number of objects omitted from the list as parts of the bottom or surface waves: see `tracker.bottom` and
    `tracker.surface`."""
    unseen: list[UnseenPart] = []
    """Parts of the sector that the ping did not observe: the list may lack obstacles there."""
    unseen_share: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Their share of the image; the list is not valid if half or more was unseen for longer than 0.5 s."""
    unseen_why: str = ""
    """Why, in plain words; empty when all was seen."""
    heard_from_db: HearingLevel | None = None
    """`Detections.heard_from_db` of the ping: objects that are not clearly stronger may be missing from the list."""
    caution: str = ""
    """`Detections.caution` of the ping."""
    poses_until: CountOrNone = -1
    """`Pose.seq` of the newest pose that the tracker knew when it made the list; -1: none."""
    poses_heard: Count = 0
    """Number of poses published to it since it started, some of which it may have lost; 0: none, or not reported."""
    made_ns: Instant = 0
    """Time when the list was made, to which `valid` and `reasons` refer; 0: not reported."""
    made_utc_ns: Instant = 0
    """The same, UTC; 0: not reported."""
    frame: Literal["ned"] = "ned"
    """Frame of all positions in the list: the local one, north east down."""
    site: Site | None = None
    """The origin of that frame; none: not reported."""
    pose: PoseAt | None = None
    """The vehicle's pose at `t_ns`, as the tracker used it; none: not known."""
    head: PoseAt | None = None
    """Pose of the sonar's head at `t_ns`, in whose frame `sector` and `unseen` are; none: not known."""
    sector: Sector | None = None
    """The region that the ping covered; none: there was no ping."""
    processed_ranges_m: list[tuple[Metres, Metres]] = []
    """`Detections.processed_ranges_m` of the ping: the rest of the sector was not searched; empty: all of it was
    searched, or there was no ping."""
    vetoes: list[Veto] = []
    """The operators' vetoes that hold, those of obstacles that are not in the list, too."""


Distance = Annotated[float, msgspec.Meta(ge=0.0, le=1e5)]
"""Horizontal, m."""


class Clearance(msgspec.Struct, frozen=True):
    """Water known to be empty, by sectors of bearing around the vehicle's origin; published with each list.

    The n sectors have one width and go clockwise from north: sector k has azimuths from k to k + 1 times 2 pi / n. The
    water from `clear_from_m` to `clear_to_m` is known to be empty. Nearer and farther water may be unknown or occupied;
    if both are 0, all of the sector is unknown. Water is unknown if it was not insonified, not processed or not
    observed by the ping (`Detections.unseen`), if it lies behind an echo, and while the list is not valid.

    Clear water is remembered from earlier pings, for the layer that the fan covered then, until an object with the
    speed `fastest_m_s` could have entered it from unobserved water. Objects with echoes weaker than
    `ObstacleList.heard_from_db` may be there nevertheless.
    """

    seq: Count
    """`seq` of the list that it belongs to."""
    ping_number: int
    """Number of the ping; -1: none."""
    t_ns: int
    """Time to which it refers, as in the list."""
    utc_ns: int
    valid: bool
    """As in the list; false: no water is known to be empty."""
    clear_from_m: list[Distance]
    """(n,) of each sector: there the water known to be empty begins,"""
    clear_to_m: list[Distance]
    """(n,) and there it ends, two standard deviations before the nearest obstacle or echo at the latest."""
    nearest_m: list[Distance | None]
    """(n,) distance to the edge of the nearest obstacle of the list or, two standard deviations nearer, echo of the
    ping; none: there is neither, which does not mean that the water is clear."""
    pose: PoseAt | None = None
    """The vehicle's at `t_ns`: the sectors are around its place. None: not known."""
    site: Site | None = None
    half_height_m: float = 0.0
    """Half the height of the empty layer, which is centred on the vehicle's origin: `tracker.clearance`."""
    fastest_m_s: float = 0.0
    """What is faster may have come in: `tracker.clearance`."""
    made_ns: Instant = 0
    """Time when it was made; 0: not reported."""
    made_utc_ns: Instant = 0


class VehicleSetPoint(msgspec.Struct, frozen=True):
    """Set point of the reference planner for the simulated vehicle; on the bench only."""

    seq: Count
    """Set points published by this planner process, from 0."""
    t_ns: Instant
    """When it was made; it holds until the next one."""
    utc_ns: Instant
    heading_rad: float
    """From north to east."""
    speed_m_s: float
    """Through the water."""
    down_m: float
    """Of the vehicle's origin."""
    list_seq: Count
    """`ObstacleList.seq` of the list that it was made of."""
    avoiding: bool
    """Something is in the way to the way-point."""
    valid: bool
    """False: that list is not valid or too old; the planner does what its settings say for that."""
    arrived: bool
    """The last way-point is reached; then no set points go to the vehicle any more."""


class SonarRequest(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True):
    """A planner's request to the sonar process to set values until the next request; without values it only asks.

    Unknown fields are refused, as a misspelt one would otherwise be answered with ok and set nothing.

    The answer comes when record 7000 of the sonar shows the new value, or when that failed: allow some seconds.
    """

    range_m: SonarRange | None = None
    power_db: SonarLevel | None = None
    """dB re 1 uPa at 1 m."""
    gain_db: SonarLevel | None = None


class SonarAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """Result of a request."""

    ok: bool
    """The sonar works with what was asked for."""
    reason: str
    """Why not, in plain words; empty when ok."""
    range_m: float | None = None
    """The range that the sonar reports now; none: it has not reported one."""
    power_db: float | None = None
    gain_db: float | None = None


VetoAction = Literal["ignore", "forget", "restore", "list"]


class VetoRequest(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True):
    """An operator's request to the tracker, on a socket that takes the keys of operators only (`ods keys`)."""

    do: VetoAction
    """ignore: an obstacle by `id`, or what rests in a `region`, for `for_s`; forget: drop an obstacle by `id`, which is
    tracked anew if there are echoes of it; restore: end a veto, by its `number`, or by the `id` of its obstacle; list:
    nothing but the answer."""
    id: ObjectId | None = None
    region: VetoRegion | None = None
    number: Count | None = None
    reason: Annotated[str, msgspec.Meta(max_length=200)] = ""
    """Why; never empty, but for `list`."""
    for_s: Annotated[float, msgspec.Meta(gt=0.0, le=LONGEST_VETO_S)] | None = None
    """How long, s; always with `ignore`, and with nothing else."""

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
            raise ValueError("for_s: needed by `ignore`, and by nothing else")


class VetoAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """Result of a request."""

    ok: bool
    reason: str
    """Why not, in plain words; empty when ok."""
    vetoes: list[Veto] = []
    """Those that hold now."""


class VetoOrder(msgspec.Struct, frozen=True, kw_only=True):
    """A request as the tracker took it, published for the record: lists after it were made with it."""

    seq: Count
    """Orders published by this tracker process, from 0."""
    t_ns: Instant
    """When it was carried out or refused."""
    utc_ns: Instant
    author: str
    """Name of the key by which it came."""
    request: VetoRequest
    refused: str
    """Why it was refused, in plain words; empty: it was carried out."""


class ReplayRequest(msgspec.Struct, frozen=True, kw_only=True, omit_defaults=True, forbid_unknown_fields=True):
    """A wish to a live replay, `ods replay --live`."""

    do: Literal["tell", "pause", "go", "step"] = "tell"
    """tell: nothing but the answer; step: go on until so many obstacle lists have been published, then pause."""
    steps: Annotated[int, msgspec.Meta(ge=1, le=1_000_000)] = 1
    speed: ReplaySpeed | None = None
    """New speed; none: keep the present one."""


class ReplayAnswer(msgspec.Struct, frozen=True, kw_only=True):
    """Where a live replay is, once the request has been followed."""

    ok: bool
    reason: str
    """Why the request was not followed, in plain words; empty when ok."""
    paused: bool = False
    at_s: float = 0.0
    """Of the recording, from its start: the newest message that was published."""
    speed: float = 1.0
    published: Count = 0
    """Messages so far."""


class Health(msgspec.Struct, frozen=True):
    """State of a process, published by each of them about twice a second."""

    process: str
    pid: int
    seq: Count
    t_ns: int
    utc_ns: int
    ready: bool
    problems: list[str]
    """Plain words; empty when all is well."""
    counters: dict[str, int]
    """Since start; every kind of loss has its own."""
    rates_hz: dict[str, float]
    """Messages a second over the last period, for each topic read or published."""
    ages_s: dict[str, float]
    """Time since the newest message of each topic read; -1 if there was none."""
    lags: dict[str, int]
    """Longest queue since the last report, for each topic read."""
    cpu_percent: float
    """Of one core, over the last period."""
    rss_mb: float


class TruthObject(msgspec.Struct, frozen=True):
    """Ground truth of a simulated object."""

    name: str
    position_ned: Vector3
    velocity_ned: Vector3
    radius_m: float
    in_sector: bool
    peak_db: float = 0.0
    """Highest expected level of its echo, dB over 1 count^2, with noise and gain as they are; 0 out of the sector."""
    background_db: float = 0.0
    """Expected level around it, likewise: the difference is its signal-to-noise ratio."""


class Truth(msgspec.Struct, frozen=True):
    """Ground truth of one ping from the simulator; on the bench only, never read on board."""

    ping_number: Count
    t_ns: int
    """Transmit time."""
    t_sent_ns: int
    """When the ping's last byte had been written to the line."""
    position_ned: Vector3
    attitude: Quaternion
    objects: list[TruthObject]


class VehicleTruth(msgspec.Struct, frozen=True):
    """Ground truth of the simulated vehicle that obeys set points; on the bench only, never read on board."""

    seq: Count
    t_ns: Instant
    scene_s: float
    """Scene time: 0 at the start of the mission."""
    position_ned: Vector3
    attitude: Quaternion
    velocity_ned: Vector3
    """Over ground, m/s."""
    stopped: bool
    """Its propeller stands still, as no set points come."""


def frame_of(ping: Ping) -> "AnyArray":
    """Return the ping's samples, (beams, samples), as a read-only view without copying.

    Raises ValueError when the buffer's length does not fit the shape.
    """
    import numpy as np

    from ods.base.arrays import SAMPLE_DTYPES

    dtype = SAMPLE_DTYPES[ping.dtype]
    if len(ping.data) != ping.beams * ping.samples * dtype.itemsize:
        raise ValueError(f"ping {ping.ping_number}: {len(ping.data)} bytes do not hold {ping.beams} x {ping.samples}")
    return np.frombuffer(ping.data, dtype).reshape(ping.beams, ping.samples)


RANGES_ABOVE = 512
"""Ranges of a range image that is shown as an image."""


def seen_from_above(ping: Ping) -> Ping:
    """Return a range image as an image by bearing and range, for pictures; any other ping as it is.

    Its levels are how many elevations have their echo at each range. Raises ValueError as `frame_of`.
    """
    if ping.range_grid is None:
        return ping
    import numpy as np

    range_m = frame_of(ping).astype(np.float64) * ping.dr_m
    dr_m = ping.range_grid.range_max_m / RANGES_ABOVE
    shown = (range_m > 0.0) & (range_m < ping.range_grid.range_max_m)
    cell = np.nonzero(shown)[0] * RANGES_ABOVE + (range_m[shown] / dr_m).astype(np.intp)
    counted = np.bincount(cell, minlength=ping.beams * RANGES_ABOVE)
    data = np.minimum(counted, 255).astype(np.uint8).tobytes()
    return msgspec.structs.replace(
        ping, samples=RANGES_ABOVE, dtype="u1", data=data, range0_m=0.5 * dr_m, dr_m=dr_m, range_grid=None
    )
