"""Messages between processes: msgspec structs, msgpack maps on the wire.

Conventions: angles in radians, SI units, world frame NED, body frame FRD, bearing positive to starboard,
elevation positive up. `t_ns` is CLOCK_MONOTONIC of this machine, `utc_ns` is nanoseconds since 1970 (UTC).
On another machine only UTC means anything. Fields whose name ends in `_ns` are 64-bit integers, and the only ones that
may exceed 2^53: JavaScript's Number rounds UTC to 256 ns, BigInt (`useBigInt64` of @msgpack/msgpack) does not. New ids
are below 2^31.
"""

from ods.messages.detections import (
    Detection as Detection,
    Detections as Detections,
    LookedVolume as LookedVolume,
    Sector as Sector,
    UnseenPart as UnseenPart,
    UnseenWhy as UnseenWhy,
)
from ods.messages.fields import (
    LARGEST_REGION_M as LARGEST_REGION_M,
    LONGEST_VETO_S as LONGEST_VETO_S,
    MOST_CORNERS as MOST_CORNERS,
    MOST_HEARING_DB as MOST_HEARING_DB,
    Angle as Angle,
    Coordinate as Coordinate,
    Coordinates as Coordinates,
    Count as Count,
    CountOrNone as CountOrNone,
    HearingLevel as HearingLevel,
    Height as Height,
    Instant as Instant,
    Metres as Metres,
    ObjectId as ObjectId,
    Part as Part,
    Quaternion as Quaternion,
    ReplaySpeed as ReplaySpeed,
    SampleType as SampleType,
    Scale as Scale,
    SonarLevel as SonarLevel,
    SonarRange as SonarRange,
    SoundSpeed as SoundSpeed,
    Speed as Speed,
    Uncertainty as Uncertainty,
    UtcSource as UtcSource,
    Vector3 as Vector3,
    Velocity as Velocity,
)
from ods.messages.health import (
    Health as Health,
)
from ods.messages.obstacles import (
    Clearance as Clearance,
    ClosestApproach as ClosestApproach,
    Distance as Distance,
    Obstacle as Obstacle,
    ObstacleList as ObstacleList,
    Outline as Outline,
    Prediction as Prediction,
    TrackState as TrackState,
)
from ods.messages.requests import (
    ReplayAnswer as ReplayAnswer,
    ReplayRequest as ReplayRequest,
    SonarAnswer as SonarAnswer,
    SonarRequest as SonarRequest,
)
from ods.messages.sonar import (
    RANGES_ABOVE as RANGES_ABOVE,
    Ping as Ping,
    RangeGrid as RangeGrid,
    Sweep as Sweep,
    frame_of as frame_of,
    seen_from_above as seen_from_above,
)
from ods.messages.truth import (
    Truth as Truth,
    TruthObject as TruthObject,
    VehicleTruth as VehicleTruth,
)
from ods.messages.vehicle import (
    Pose as Pose,
    PoseAt as PoseAt,
    Site as Site,
    VehicleSetPoint as VehicleSetPoint,
)
from ods.messages.vetoes import (
    Veto as Veto,
    VetoAction as VetoAction,
    VetoAnswer as VetoAnswer,
    VetoOrder as VetoOrder,
    VetoRegion as VetoRegion,
    VetoRequest as VetoRequest,
)
