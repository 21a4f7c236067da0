"""Building blocks of typed settings: the base struct and number types with ranges. No I/O; `ods.config` loads files."""

from typing import Annotated

import msgspec

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NonNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Seconds = Annotated[float, msgspec.Meta(gt=0.0, le=86_400.0)]
"""A duration, a day at most: longer ones overflow where they become ns or a wait of the operating system."""
NonNegativeSeconds = Annotated[float, msgspec.Meta(ge=0.0, le=86_400.0)]
Fraction = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
PositiveInt = Annotated[int, msgspec.Meta(ge=1)]
NonNegativeInt = Annotated[int, msgspec.Meta(ge=0)]
OddInt = Annotated[int, msgspec.Meta(ge=1, le=999)]


class Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of every settings struct: keyword only, immutable, unknown keys are errors.

    `__post_init__` of a subclass may raise ValueError for what a type cannot say; name the key in its text.
    """
