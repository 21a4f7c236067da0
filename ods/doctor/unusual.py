"""Numbers that are allowed, but surely a mistake: a wrong unit, a point too few."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from msgspec import inspect

from ods.base.field_docs import field_docs
from ods.base.settings import Settings, Slider
from ods.config import OnboardConfig
from ods.doctor.finding import Finding
from ods.pipeline.settings import PipelineSettings
from ods.pipeline.stage.params import BUILT_IN, read_params


class _Set(NamedTuple):
    """A number of the configuration of which it is known what is usual."""

    key: str
    value: float
    usual: Slider
    meaning: str


def examine(settings: OnboardConfig) -> Iterator[Finding]:
    """Name each number that lies beyond what its slider shows, and say what it does."""
    for key, value, usual, meaning in (*_numbers(settings, ""), *_of_stages(settings.pipeline)):
        if not usual.low <= value <= usual.high:
            span = f"{usual.low:g} to {usual.high:g} {usual.unit}".rstrip()
            first = meaning.partition(". ")[0].rstrip(".")
            yield Finding("note", "configuration", f"{key} = {value:g} is unusual, {span} is usual: {first}")


def _numbers(settings: Settings, path: str) -> Iterator[_Set]:
    """Yield those that are not as they are by default, of the tables inside, too."""
    kind = inspect.type_info(type(settings))
    assert isinstance(kind, inspect.StructType)
    meanings = field_docs(kind.cls)
    for field in kind.fields:
        value, key = getattr(settings, field.name), f"{path}{field.encode_name}"
        if isinstance(value, Settings):
            yield from _numbers(value, f"{key}.")
        elif value != field.default:
            yield from _one(field.type, value, key, meanings)


def _one(kind: inspect.Type, value: Any, key: str, meanings: Mapping[str, str]) -> Iterator[_Set]:
    """Yield a number, or those of a tuple."""
    if isinstance(kind, inspect.VarTupleType):
        for item in value:
            yield from _one(kind.item_type, item, key, meanings)
    elif isinstance(kind, inspect.TupleType):
        for item_kind, item in zip(kind.item_types, value, strict=True):
            yield from _one(item_kind, item, key, meanings)
    elif isinstance(kind, inspect.Metadata) and (usual := (kind.extra or {}).get("slider")):
        yield _Set(key, value, usual, meanings.get(key.rpartition(".")[2], ""))


def _of_stages(settings: PipelineSettings) -> Iterator[_Set]:
    """Yield the numbers of stages that come with ODS."""
    for index, table in enumerate(settings.stage):
        if table["use"] in BUILT_IN:
            params = read_params(BUILT_IN[table["use"]], table)
            yield from _numbers(params, f"pipeline.stage[{index}].")
