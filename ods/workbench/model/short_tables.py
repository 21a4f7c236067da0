"""Settings as the tables of a TOML file that says no more than it must."""

from typing import Any

import msgspec

from ods.base.settings import Settings
from ods.workbench.model.paths import tables_of


def short_tables(settings: Settings) -> dict[str, Any]:
    """Return settings as tables; what is as by default is left out, as is None, which TOML has not."""
    kind = type(settings).__struct_config__
    tables: dict[str, Any] = {kind.tag_field: kind.tag} if kind.tag_field else {}
    for field in msgspec.structs.fields(settings):
        value = getattr(settings, field.name)
        if value is not None and (field.required or value != _default(field)):
            tables[field.encode_name] = _short(value)
    return tables


def _short(value: Any) -> Any:
    if isinstance(value, Settings):
        return short_tables(value)
    if isinstance(value, list | tuple):
        return [_short(item) for item in value]
    if isinstance(value, dict):
        return {name: _short(item) for name, item in value.items()}
    return tables_of(value)


def _default(field: msgspec.structs.FieldInfo) -> Any:
    return field.default_factory() if field.default_factory is not msgspec.NODEFAULT else field.default
