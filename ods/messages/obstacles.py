"""Messages to planners: the obstacle list, and the clearance."""

from typing import Annotated, Literal

import msgspec

from ods.messages.detections import Sector, UnseenPart
from ods.messages.fields import Count, CountOrNone, HearingLevel, Instant, Metres, ObjectId, UtcSource, Vector3
from ods.messages.vehicle import PoseAt, Site
from ods.messages.vetoes import Veto

TrackState = Literal["active", "stand_by", "hibernated", "terminated"]


class ClosestApproach(msgspec.Struct, frozen=True, gc=False):
    """Closest point of approach if obstacle and vehicle keep their velocities.

    In the horizontal plane, from the vehicle's origin to the obstacle's edge.
    """

    time_s: float
    """After the list's `t_ns`, up to `tracker.planner.approach_horizon_s`. 0: the distance is smallest now."""
    distance_m: float
    """Below 0: inside the obstacle."""
    sigma_m: float
    """Of `distance_m`, including the effect of the velocity error on the time: an object that seems to fall behind may
    approach."""


class Prediction(msgspec.Struct, frozen=True, gc=False):
    """Predicted position if the obstacle keeps its velocity."""

    lead_s: float
    """After the list's `t_ns`."""
    position_ned: Vector3
    sigma_position: Vector3
    """Manoeuvres included."""


class Outline(msgspec.Struct, frozen=True, gc=False):
    """The visible part of an elongated object as a strip in the horizontal plane."""

    middle_ne: tuple[float, float]
    """As accurate as the obstacle's position."""
    half_length_m: float
    half_width_m: float
    azimuth_rad: float
    """Of its long axis, clockwise from north, in [0, pi)."""
    sigma_half_length_m: float


class Obstacle(msgspec.Struct, frozen=True):
    """One tracked object [SSIE figure 5]."""

    id: ObjectId
    """The same while the tracker follows the object."""
    state: TrackState
    """active: observed; stand_by: not for some seconds, or less certain; hibernated: static, out of view, in the map.
    Keep clear of all three. terminated: ended; ignore it."""
    position_ned: Vector3
    """Of its centre."""
    velocity_ned: Vector3
    """Over ground, m/s; zero for a static object."""
    radius_m: float
    sigma_position: Vector3
    sigma_velocity: Vector3
    """For a static object: the largest velocity that its echoes do not yet exclude."""
    sigma_radius: float
    first_seen_utc_ns: int
    last_seen_utc_ns: int
    times_seen: Count
    """Pings with its echo."""
    existence: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
    """Probability."""
    covariance_ne: float = 0.0
    """Covariance of north and east position, m^2."""
    cpa: ClosestApproach | None = None
    """None without the vehicle's pose, and when terminated."""
    predicted: list[Prediction] = []
    """At each of `tracker.planner.lead_times_s`; empty when terminated."""
    unseen_s: Annotated[float, msgspec.Meta(ge=0.0)] = 0.0
    """Time since its last echo during which its position was not observed: coasted, not missed."""
    bottom_probability: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """That it rises no higher over the bottom than `tracker.bottom.clearance_m`; 0: the pose has no altitude."""
    height_above_bottom_m: float | None = None
    """Of the middle of its visible part; none: not known."""
    sigma_height_above_bottom_m: float | None = None
    """Large with a sonar of one plane."""
    moving: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Probability that it moves."""
    multipath_of: CountOrNone = -1
    """Id of the obstacle of which it is probably a multipath echo; -1: none. It may still be a real object."""
    near_m: float | None = None
    """Slant range from the sonar's head to the nearest point, more accurate than position and radius. None: not seen
    for 2 s, no near edge, or no ping."""
    sigma_near_m: float | None = None
    elongated: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Probability that it is longer than 3 m, and than 4 times its width."""
    outline: Outline | None = None
    """Where `elongated` exceeds 0.9, within the circle."""
    ignored_by: CountOrNone = -1
    """`Veto.number` of the veto by which planners may ignore it; -1: none."""


class ObstacleList(msgspec.Struct, frozen=True):
    """The complete list of obstacles, at every ping and at least twice a second."""

    seq: Count
    ping_number: int
    """-1: a list without a ping, which is not valid."""
    t_ns: int
    """Time to which the list refers: the ping's transmission, or now."""
    utc_ns: int
    t_rx_ns: int
    """0: no ping."""
    valid: bool
    """False: it may be incomplete or wrong; `reasons` says why."""
    reasons: list[str]
    obstacles: list[Obstacle]
    utc_source: UtcSource = "unsure"
    left_out: Count = 0
    """Objects omitted: `tracker.planner.most_listed` others are nearer."""
    bottom_left_out: Count = 0
    """Objects omitted as bottom or waves: `tracker.bottom`, `tracker.surface`."""
    unseen: list[UnseenPart] = []
    """What the ping did not observe."""
    unseen_share: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)] = 0.0
    """Their share; above a half for 0.5 s, the list is not valid."""
    unseen_why: str = ""
    """Empty when everything was observed."""
    heard_from_db: HearingLevel | None = None
    """As in `Detections`: objects that are not clearly stronger may be missing."""
    caution: str = ""
    """As in `Detections`."""
    poses_until: CountOrNone = -1
    """As in `Detections`, of the tracker."""
    poses_heard: Count = 0
    """As in `Detections`, of the tracker."""
    made_ns: Instant = 0
    """When the list was made, to which `valid` and `reasons` refer."""
    made_utc_ns: Instant = 0
    frame: Literal["ned"] = "ned"
    """Local north east down."""
    site: Site | None = None
    """Its origin."""
    pose: PoseAt | None = None
    """The vehicle's at `t_ns`; none: not known."""
    head: PoseAt | None = None
    """The sonar head's; `sector` and `unseen` are in its frame."""
    sector: Sector | None = None
    """None: no ping."""
    processed_ranges_m: list[tuple[Metres, Metres]] = []
    """As in `Detections`; empty: all, or no ping."""
    vetoes: list[Veto] = []
    """All that hold."""


Distance = Annotated[float, msgspec.Meta(ge=0.0, le=1e5)]
"""Horizontal, m."""


class Clearance(msgspec.Struct, frozen=True):
    """Water known to be empty, by bearing sectors around the vehicle's origin; published with each list.

    The n sectors have one width and go clockwise from north: sector k has azimuths from k to k + 1 times 2 pi / n.
    Both limits are 0 where all is unknown: what the ping did not observe or process, behind an echo, and while the
    list is not valid.

    Clear water is remembered until an object of speed `fastest_m_s` could have entered it. It may still contain objects
    with echoes weaker than `ObstacleList.heard_from_db`.
    """

    seq: Count
    """As of its list."""
    ping_number: int
    t_ns: int
    """As in the list."""
    utc_ns: int
    valid: bool
    """False: no water is known to be empty."""
    clear_from_m: list[Distance]
    """(n,) where the empty water begins."""
    clear_to_m: list[Distance]
    """(n,) where it ends: two sigmas before the nearest obstacle or echo at the latest."""
    nearest_m: list[Distance | None]
    """(n,) to the edge of the nearest obstacle or, two sigmas nearer, echo; none: there is neither, but the water need
    not be clear."""
    pose: PoseAt | None = None
    """The vehicle's at `t_ns`."""
    site: Site | None = None
    half_height_m: float = 0.0
    """Half the height of the layer around the vehicle's origin."""
    fastest_m_s: float = 0.0
    """Faster objects may have entered."""
    made_ns: Instant = 0
    made_utc_ns: Instant = 0
