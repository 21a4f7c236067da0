"""Controls of settings: a slider, a switch, a choice or a text, as its type says.

Types may say how they are shown: `ods.base.settings.slider`. Those that do not, such as those of a stage of the user's
own, get what their bounds and their default suggest.
"""

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import msgspec
from msgspec import inspect

from ods.base.field_docs import field_docs
from ods.base.settings import Settings, Slider
from ods.workbench.model.words import called

LOG_POSITIONS = 120
LINEAR_POSITIONS = 200
"""Of sliders whose step is not reported."""
SPREAD = 30.0
"""A number of which only the sign is known is shown from its default over this factor to its default times it."""
DIGITS = 3
"""Significant digits of what a logarithmic slider gives."""


class Number(NamedTuple):
    """A slider, which has places 0 to `places` - 1; beside it any number that the setting takes can be written."""

    low: float
    high: float
    step: float
    """Of a logarithmic one that begins with 0 the first value above it."""
    log: bool = False
    whole: bool = False
    unit: str = ""

    @property
    def places(self) -> int:
        """Return how many values it has."""
        return LOG_POSITIONS + 1 if self.log else round((self.high - self.low) / self.step) + 1

    def value_at(self, place: int) -> float | int:
        """Return the value at a place."""
        last = self.places - 1
        if place <= 0 or place >= last:
            value = self.low if place <= 0 else self.high
        elif self.log:
            first = self.low or self.step
            share = (place - 1) / (last - 1) if self.low == 0.0 else place / last
            value = float(f"{first * (self.high / first) ** share:.{DIGITS}g}")
        else:
            value = round(self.low + place * self.step, 12)
        value = min(max(value, self.low), self.high)
        return round(value) if self.whole else value

    def place_of(self, value: float) -> int:
        """Return the place nearest to a value."""
        last = self.places - 1
        if not self.log:
            return min(max(round((value - self.low) / self.step), 0), last)
        if value <= self.low:
            return 0
        first = self.low or self.step
        share = math.log(max(value, first) / first) / math.log(self.high / first)
        return min(round(1 + share * (last - 1) if self.low == 0.0 else share * last), last)


class Switch(NamedTuple):
    """On or off."""


class Choice(NamedTuple):
    """One of a few."""

    options: tuple[str | int, ...]


class Text(NamedTuple):
    """Anything, written as JSON."""


class Control(NamedTuple):
    """How one setting is changed."""

    path: str
    """From the settings it is part of: "motion.velocity_sigma"."""
    by: Number | Switch | Choice | Text
    default: Any
    """As TOML has it."""
    meaning: str = ""
    label: str = ""
    """What it is called where that is not the field's own name."""

    @property
    def name(self) -> str:
        """Return what it is called, in words."""
        return self.label or called(self.path.rpartition(".")[2]).name

    @property
    def unit(self) -> str:
        """Return its unit; empty: none."""
        own = self.by.unit if isinstance(self.by, Number) else ""
        return own or called(self.path.rpartition(".")[2]).unit


def controls_of(
    kind: type[Settings], names: Mapping[str, Sequence[str]] | None = None, path: str = ""
) -> list[Control]:
    """Return the controls of all fields of a settings type, those of tables inside it among them, in their order.

    names: what texts may be, by path, where a register knows.
    """
    info = inspect.type_info(kind)
    assert isinstance(info, inspect.StructType)
    meaning = field_docs(kind)
    found: list[Control] = []
    for field in info.fields:
        here = f"{path}{field.encode_name}"
        if isinstance(field.type, inspect.StructType) and issubclass(field.type.cls, Settings):
            found += controls_of(field.type.cls, names, f"{here}.")
            continue
        default = _default(field)
        known = (names or {}).get(here)
        by = Choice(tuple(known)) if known else _by(field.type, default)
        found.append(Control(here, by, default, meaning.get(field.name, "")))
    return found


def text_of(value: Any) -> str:
    """Return a value as it is written into a text field."""
    return msgspec.json.encode(value, enc_hook=str).decode()


def value_of(text: str) -> Any:
    """Return what a text field says: JSON, or, where it is not JSON, the text itself."""
    try:
        return msgspec.json.decode(text)
    except msgspec.DecodeError:
        return text


def _default(field: inspect.Field) -> Any:
    if field.default is not msgspec.NODEFAULT:
        value = field.default
    elif field.default_factory is not msgspec.NODEFAULT:
        value = field.default_factory()
    else:
        return None
    return msgspec.to_builtins(value, enc_hook=str)


def _by(kind: inspect.Type, default: Any) -> Number | Switch | Choice | Text:
    extra: Mapping[str, Any] = {}
    if isinstance(kind, inspect.Metadata):
        extra, kind = kind.extra or {}, kind.type
    if isinstance(kind, inspect.BoolType):
        return Switch()
    if isinstance(kind, inspect.LiteralType):
        return Choice(tuple(value for value in kind.values if isinstance(value, str | int)))
    if isinstance(kind, inspect.EnumType):
        return Choice(tuple(item.value for item in kind.cls))
    if isinstance(kind, inspect.IntType | inspect.FloatType):
        return _number(kind, default, extra)
    return Text()


def _number(kind: inspect.IntType | inspect.FloatType, default: Any, extra: Mapping[str, Any]) -> Number:
    whole = isinstance(kind, inspect.IntType)
    odd = bool(extra.get("odd"))
    shown: Slider | None = extra.get("slider")
    if shown is not None:
        step = shown.step or (2.0 if odd else 1.0 if whole else (shown.high - shown.low) / LINEAR_POSITIONS)
        return Number(shown.low, shown.high, step, shown.log, whole, shown.unit)
    middle = float(default) if isinstance(default, int | float) else 1.0
    low, high = _least(kind, whole), _most(kind, whole)
    if low is None and high is None:
        low, high = -4.0 * (abs(middle) or 1.0), 4.0 * (abs(middle) or 1.0)
    elif high is None and kind.gt == 0 and not whole:
        return Number((middle or 1.0) / SPREAD, (middle or 1.0) * SPREAD, 0.0, log=True)
    elif high is None:
        assert low is not None
        high = low + 4.0 * ((middle - low) or 2.5)
    elif low is None:
        low = high - 4.0 * ((high - middle) or 2.5)
    assert low is not None
    step = _step(high - low, whole, odd)
    if not whole:
        low, high = low + step * (kind.gt is not None), high - step * (kind.lt is not None)
    elif odd:
        low = low + 1.0 - low % 2.0
    return Number(low, low + step * math.floor((high - low) / step + 1e-9), step, whole=whole)


def _step(span: float, whole: bool, odd: bool) -> float:
    if odd:
        return 2.0
    if whole:
        return max(1.0, float(round(span / LINEAR_POSITIONS)))
    return span / LINEAR_POSITIONS


def _least(kind: inspect.IntType | inspect.FloatType, whole: bool) -> float | None:
    if kind.ge is not None:
        return float(kind.ge)
    return None if kind.gt is None else float(kind.gt) + (1.0 if whole else 0.0)


def _most(kind: inspect.IntType | inspect.FloatType, whole: bool) -> float | None:
    if kind.le is not None:
        return float(kind.le)
    return None if kind.lt is None else float(kind.lt) - (1.0 if whole else 0.0)
