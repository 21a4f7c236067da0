"""Numbers in messages: types with bounds, as messages are untrusted input."""

from typing import Annotated, Literal

import msgspec

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
