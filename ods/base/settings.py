"""Building blocks of typed settings: the base struct and number types with ranges. No I/O: `settings_file` loads."""

import re
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


def complaint_of(error: msgspec.ValidationError) -> str:
    """Turn "Expected `float`, got `str` - at `$.a.b`" into "a.b: expected `float`, got `str`"."""
    text = str(error)
    match = re.fullmatch(r"(.*) - at `\$\.?(.*)`", text, re.DOTALL)
    message, key = (match[1], match[2]) if match else (text, "")
    message = message.replace(" | null", "")  # TOML has no null
    field = re.search(r"(unknown|required) field `([^`]+)`", message)
    if field:
        key = f"{key}.{field[2]}" if key else field[2]
        message = "unknown key" if field[1] == "unknown" else "missing"
    return f"{key}: {message[:1].lower()}{message[1:]}" if key else message
