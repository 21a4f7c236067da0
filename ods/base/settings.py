"""Building blocks of typed settings: the base struct and number types with ranges. No I/O: `settings_file` loads."""

import re
from typing import Annotated, NamedTuple

import msgspec

from ods.base.allowed_names import allowed_names
from ods.base.choices import nearest, none_of
from ods.base.units import unit_of

Positive = Annotated[float, msgspec.Meta(gt=0.0)]
NonNegative = Annotated[float, msgspec.Meta(ge=0.0)]
Seconds = Annotated[float, msgspec.Meta(gt=0.0, le=86_400.0)]
"""A duration, a day at most: longer ones overflow where they become ns or a wait of the operating system."""
NonNegativeSeconds = Annotated[float, msgspec.Meta(ge=0.0, le=86_400.0)]
Fraction = Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
PositiveInt = Annotated[int, msgspec.Meta(ge=1)]
NonNegativeInt = Annotated[int, msgspec.Meta(ge=0)]
OddInt = Annotated[int, msgspec.Meta(ge=1, le=999, extra={"odd": True})]
"""Has a middle. No bound of a type can say so: `refuse_even` does."""


class Slider(NamedTuple):
    """How a number is shown where it is set by hand; it may have any value that its type allows, but `ods doctor` calls
    one beyond unusual."""

    low: float
    high: float
    step: float = 0.0
    """0: as the range suggests. Of a logarithmic slider that begins with 0 the first value above it."""
    log: bool = False
    unit: str = ""


def slider(low: float, high: float, *, step: float = 0.0, log: bool = False, unit: str = "") -> msgspec.Meta:
    """Return what to put beside a number's type: `Annotated[Positive, slider(0.1, 10.0, log=True, unit="m")]`."""
    return msgspec.Meta(extra={"slider": Slider(low, high, step, log, unit)})


def unit(text: str) -> msgspec.Meta:
    """Return what to put beside a number's type where neither its key's ending nor a slider has its unit."""
    return msgspec.Meta(extra={"unit": text})


class Settings(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """Base of every settings struct: keyword only, immutable, unknown keys are errors.

    `__post_init__` of a subclass may raise ValueError for what a type cannot say; name the key in its text.
    """


def refuse_even(settings: Settings) -> None:
    """Raise ValueError, which names the key, for an even number where an `OddInt` belongs."""
    kind = msgspec.inspect.type_info(type(settings))
    for field in kind.fields if isinstance(kind, msgspec.inspect.StructType) else ():
        odd = isinstance(field.type, msgspec.inspect.Metadata) and (field.type.extra or {}).get("odd")
        value = getattr(settings, field.name)
        if odd and value % 2 == 0:
            raise ValueError(f"{field.encode_name}: expected an odd number, got {value}")


BOUNDS = {"<=": "at most", ">=": "at least", "<": "less than", ">": "more than"}
TYPES = {
    "str": "a string", "int": "an integer", "float": "a number", "bool": "a boolean", "date": "a date",
    "datetime": "a date", "time": "a time", "array": "a list", "list": "a list", "object": "a table", "dict": "a table",
}  # fmt: skip
"""What msgspec calls a type, in the words of TOML."""


def complaint_of(error: msgspec.ValidationError, kind: type) -> str:
    """Turn msgspec's error about a `kind` into a line that begins with the key.

    "Expected `float`, got `str` - at `$.a.b`" becomes "a.b: expected a number, got a string"; names that `kind` does
    not know, of keys and of choices, come with those that it does, and numbers with their unit.
    """
    text = str(error)
    match = re.fullmatch(r"(.*) - at (?:`key` in )?`\$\.?(.*)`", text, re.DOTALL)
    message, key = (match[1], match[2]) if match else (text, "")
    own = re.match(r"(\w+)[\w.\[\]]*(?=: )", message)  # a `__post_init__` begins with the key below its table
    if own and own[1] in allowed_names(kind, key):
        key, message = _below(key, own[0]), message[own.end() + 2 :]
    chosen = re.fullmatch(r"Invalid enum value (?:'(?P<text>.*)'|(?P<number>-?\d+))", message, re.DOTALL)
    if chosen:
        given = int(chosen["number"]) if chosen["number"] else chosen["text"]
        message = none_of(given, allowed_names(kind, key))
    field = re.search(r"(unknown|required) field `([^`]+)`", message)
    if field:
        message = "missing" if field[1] == "required" else f"unknown key{_near_key(kind, key, field[2])}"
        key = _below(key, field[2])
    elif message.startswith("Expected `"):
        message = _expected(message, unit_of(kind, key))
    return f"{key}: {message[:1].lower()}{message[1:]}" if key else message


def _below(table: str, key: str) -> str:
    return f"{table}.{key}" if table else key


def _near_key(kind: type, table: str, key: str) -> str:
    """Return " (did you mean stale_s, in seconds)", "" when no key of the table is near."""
    near = nearest(key, allowed_names(kind, table))
    if near is None:
        return ""
    unit = unit_of(kind, _below(table, str(near)))
    return f" (did you mean {near}, in {unit})" if unit else f" (did you mean {near})"


def _expected(message: str, unit: str) -> str:
    """Return what msgspec says of a wrong value in words, with the unit, "" for none."""
    bound = re.fullmatch(r"Expected `(?:int|float)` (>=|<=|>|<) (\S+)", message)
    if bound:
        return f"must be {BOUNDS[bound[1]]} {float(bound[2]):.15g}{f' ({unit})' if unit else ''}"
    message = re.sub(r"`([^`]+)`", lambda types: _in_words(types[1]), message).replace("got a number", "got a float")
    return f"{message}; it is in {unit}" if unit else message


def _in_words(types: str) -> str:
    """Return "a number or a string" of "float | str | null": TOML has no null."""
    return " or ".join(dict.fromkeys(TYPES.get(name, name) for name in types.split(" | ") if name != "null"))
