"""Messages to planners: the obstacle list, and the clearance."""

from typing import Annotated, Literal

import msgspec

from ods.messages.detections import Sector, UnseenPart
from ods.messages.fields import Count, CountOrNone, HearingLevel, Instant, Metres, ObjectId, UtcSource, Vector3
from ods.messages.vehicle import PoseAt, Site
from ods.messages.vetoes import Veto

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
    """The same while the tracker follows the object."""
    state: TrackState
    """active: observed; stand_by: not for some seconds, or less certain; hibernated: static, out of view, in the map.
    Keep clear of all three. terminated: ended; ignore it."""
    position_ned: Vector3
    """Of its middle, m."""
    velocity_ned: Vector3
    """Over ground, m/s; zero for a static object."""
    radius_m: float
    """Of its circle."""
    sigma_position: Vector3
    """Standard deviations, m, north east down."""
    sigma_velocity: Vector3
    """Standard deviations, m/s, north east down. For a static object: the largest velocity that its echoes do not
    exclude yet."""
    sigma_radius: float
    first_seen_utc_ns: int
    last_seen_utc_ns: int
    times_seen: Count
    """Pings with its echo."""
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
    """Their share of the image; the list is not valid if more than half was unseen for longer than 0.5 s."""
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
