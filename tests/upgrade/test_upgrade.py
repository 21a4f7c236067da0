"""What a vehicle that ran an older ODS brings along: configurations and a map, upgraded as the changelog promises."""

import re
import shutil
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

from ods.base.settings_file import ConfigError, load
from ods.config import OnboardConfig
from ods.tracker.map.map_object import MapObject
from ods.tracker.map.store import open_map

CHANGELOG = Path(__file__).parents[2] / "CHANGELOG.md"
ORIGIN_DEG = (57.048, 9.9187)
VERSIONS = ["0.4.0", "0.5.0"]


def folder_of(version: str) -> Path:
    """Return the folder with files of that version."""
    return Path(__file__).parent / f"v{version.replace('.', '_')}"


def keys_of(tables: dict[str, object], name: str = "") -> Iterator[tuple[str, str, object]]:
    """Yield table, key and value of every key of nested tables."""
    for key, value in tables.items():
        if isinstance(value, dict):
            yield from keys_of(value, f"{name}.{key}".lstrip("."))
        else:
            yield name, key, value


def old_keys() -> list[tuple[str, str, str, object]]:
    """Return version, table, key and default of every on-board key but those of plug-ins and of DBC signals."""
    return [
        (version, *each)
        for version in VERSIONS
        for each in keys_of(tomllib.loads((folder_of(version) / "defaults.toml").read_text()))
    ]


def refused_keys(version: str) -> set[str]:
    """Return the keys in the first column of the changelog's table for that version, in full."""
    section = CHANGELOG.read_text().partition(f"| {version} | now |")[2].split("\n\n")[0]
    cells = [line.split("|")[1] for line in section.splitlines() if line.startswith("| ")]
    return {name for cell in cells for name in re.findall(r"`\[?([a-z_.]+)\]?`", cell)}


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("name", ["onboard.toml", "onboard-sbg.toml"])
def test_configurations_that_came_with_it_are_read(version: str, name: str) -> None:
    load(folder_of(version) / name, OnboardConfig)


@pytest.mark.parametrize(("version", "table", "key", "value"), old_keys(), ids=lambda part: str(part)[:30])
def test_each_key_is_read_or_the_changelog_says_what_became_of_it(
    version: str, table: str, key: str, value: object, tmp_path: Path
) -> None:
    for name in ("ins.eds", "ods_node.eds"):
        shutil.copy(folder_of(version) / name, tmp_path)
    config = tomllib.loads((folder_of(version) / "onboard.toml").read_text())
    owner = config
    for part in table.split("."):
        owner = owner.setdefault(part, {})
    owner[key] = value
    file = tmp_path / "onboard.toml"
    file.write_text(_as_toml(config))
    if not {f"{table}.{key}", table} & refused_keys(version):
        load(file, OnboardConfig)
        return
    with pytest.raises(ConfigError) as refused:
        load(file, OnboardConfig)
    assert table in str(refused.value)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("version", VERSIONS)
def test_its_map_is_taken_as_it_is(version: str, tmp_path: Path) -> None:
    shutil.copy(folder_of(version) / "map.sqlite", tmp_path)
    store = open_map(tmp_path / "map.sqlite", *ORIGIN_DEG)
    first, second = store.load()
    free = store.first_free_id()
    store.close()
    seen = (10**18, 10**18 + 10**9, 10**18 + 2 * 10**9)
    assert first == MapObject(3, (40.0, -5.5, 12.0), (0.2, 0.3, 3.0), 1.5, 0.1, 0.99, 12, *seen, 0.01)
    assert (second.id, second.position, second.covariance_ne) == (8, (61.25, 7.0, 15.0), -0.02)
    assert free == 1000  # as that mission had reserved them: no id is used twice


def _as_toml(tables: dict[str, object], name: str = "") -> str:
    """Return tables of numbers, texts, lists and further tables as TOML."""
    own = {key: value for key, value in tables.items() if not isinstance(value, dict)}
    text = f"[{name}]\n" if name else ""
    text += "".join(f"{key} = {str(v).lower() if isinstance(v, bool) else repr(v)}\n" for key, v in own.items())
    for key, value in tables.items():
        if isinstance(value, dict):
            text += _as_toml(value, f"{name}.{key}".lstrip("."))
    return text
