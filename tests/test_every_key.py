"""Every key of every table, with a value that no key can have: one line that names the file and the key."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from msgspec import inspect

from ods.base.settings import Settings
from ods.base.settings_file import ConfigError, load
from ods.bench.settings import BenchConfig
from ods.config import OnboardConfig

Steps = tuple[str | int, ...]


def keys(place: inspect.Type, steps: Steps = ()) -> Iterator[tuple[Steps, inspect.Type]]:
    """Yield the way to all that may stand in `place`, by names and places in lists; any name where any may be."""
    match place:
        case inspect.Metadata():
            yield from keys(place.type, steps)
        case inspect.UnionType():
            for one in place.types:
                yield from keys(one, steps)
        case _:
            yield steps, place
    match place:
        case inspect.StructType():
            for field in place.fields:
                yield from keys(field.type, (*steps, field.encode_name))
        case inspect.DictType():
            yield from keys(place.value_type, (*steps, some_name(place)))
        case inspect.ListType() | inspect.VarTupleType():
            yield from keys(place.item_type, (*steps, 0))


def some_name(place: inspect.DictType) -> str:
    return str(place.key_type.values[0]) if isinstance(place.key_type, inspect.LiteralType) else "any-name"


def named(steps: Steps) -> str:
    return "".join(f"[{step}]" if isinstance(step, int) else f".{step}" for step in steps).removeprefix(".")


def toml(steps: Steps, value: str) -> str:
    first, *rest = steps
    for step in reversed(rest):
        value = f"[{value}]" if isinstance(step, int) else f"{{{step} = {value}}}"
    return f"{first} = {value}\n"


def complaint(file: Path, kind: type[Settings], steps: Steps, value: str) -> str:
    file.write_text(toml(steps, value))
    with pytest.raises(ConfigError) as refused:
        load(file, kind)
    return str(refused.value)


@pytest.mark.parametrize("kind", [OnboardConfig, BenchConfig])
def test_each_wrong_value_is_one_line_with_its_key(tmp_path: Path, kind: type[Settings]) -> None:
    file, tried = tmp_path / "some.toml", set()
    for steps, place in keys(inspect.type_info(kind)):
        if not steps or isinstance(place, inspect.AnyType):
            continue
        tried.add(named(steps))
        for value, said in (("2026-01-01", "expected "), ("nan", "must be a finite number, got nan")):
            assert complaint(file, kind, steps, value).startswith(f"{file}: {named(steps)}: {said}")
        if isinstance(place, inspect.StructType):
            assert complaint(file, kind, (*steps, "colour"), "1") == f"{file}: {named(steps)}.colour: unknown key"
    assert len(tried) > 25


ENDINGS = {
    "_deg_s": "degrees/s",
    "_m_s": "m/s",
    "_m": "metres",
    "_s": "seconds",
    "_ms": "milliseconds",
    "_deg": "degrees",
    "_hz": "Hz",
    "_db": "dB",
}


@pytest.mark.parametrize("kind", [OnboardConfig, BenchConfig])
def test_each_number_with_a_unit_is_refused_with_it(tmp_path: Path, kind: type[Settings]) -> None:
    file, tried = tmp_path / "some.toml", 0
    for steps, place in keys(inspect.type_info(kind)):
        names = [step for step in steps if isinstance(step, str)]
        unit = next((unit for ending, unit in ENDINGS.items() if names and names[-1].endswith(ending)), "")
        if unit and isinstance(place, inspect.FloatType | inspect.IntType):
            tried += 1
            assert complaint(file, kind, steps, "'3 m'").endswith(f"; it is in {unit}"), steps
            for bound, value in ((place.le, 1e300), (place.lt, 1e300), (place.ge, -1e300), (place.gt, -1e300)):
                if bound is not None:
                    said = complaint(file, kind, steps, str(value) if isinstance(place, inspect.FloatType) else "-1")
                    assert ": must be " in said, steps
                    assert said.endswith(f" ({unit})"), steps
    assert tried > 10
