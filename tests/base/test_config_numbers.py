"""Every number of the configuration, made absurd: it loads and the worker can be made, or one line names the key."""

import tomllib
from collections import Counter
from collections.abc import Iterator
from copy import deepcopy
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import msgspec.inspect as inspect
import pytest
import tomli_w

from ods.base.errors import OdsError
from ods.base.settings import Settings
from ods.base.settings_file import load
from ods.bench.settings import BenchConfig
from ods.config import OnboardConfig, part_of
from ods.nav_bridge.service import NavWorker
from ods.nav_bridge.settings import POSE_OBJECTS, NavConfig
from ods.runtime.service import Service
from ods.sonar_link.service import SonarWorker
from ods.sonar_link.settings import SonarConfig

CONFIG = Path(__file__).parents[2] / "config"
ABSURD = [0, -1, 1e-300, -1e300, 1e300, 1e39, 10**18, 2**63, 2**64, 10**400, -(10**400)]
Key = tuple[str, ...]
ITEM = "[]"
"""In a key: the first of a list, or of a table with free names."""
OPTIONS = ("nav", "can", "options", ITEM)
"""Passed on to python-can as they are."""


def numeric_keys(kind: inspect.Type, key: Key = ()) -> Iterator[Key]:
    if isinstance(kind, inspect.Metadata):
        yield from numeric_keys(kind.type, key)
    elif isinstance(kind, inspect.UnionType):
        for choice in kind.types:
            yield from numeric_keys(choice, key)
    elif isinstance(kind, inspect.StructType):
        for field in kind.fields:
            yield from numeric_keys(field.type, (*key, field.encode_name))
    elif isinstance(kind, inspect.ListType | inspect.VarTupleType):
        yield from numeric_keys(kind.item_type, (*key, ITEM))
    elif isinstance(kind, inspect.DictType):
        yield from numeric_keys(kind.value_type, (*key, ITEM))
    elif isinstance(kind, inspect.IntType | inspect.FloatType):
        yield key


def keys_of(config: type[Settings]) -> list[Key]:
    return sorted(set(numeric_keys(inspect.type_info(config))) - {OPTIONS})


def onboard(folder: Path, source: str) -> dict[str, Any]:
    """Return a configuration that has one of everything."""
    files = {"canopen": "onboard.toml", "dbc": "onboard-sbg.toml", "nmea": "onboard-nmea.toml"}
    data = tomllib.loads((CONFIG / files[source]).read_text())
    data["bus"]["run_dir"] = str(folder)
    data["sonar"] = {"port": str(folder / "no-such-device"), "range_m": 50.0, "gain_db": 0.0, "power_db": 0.0}
    data["bridge"] = {name: {"to": "udp://127.0.0.1:5005"} for name in ("json", "ttm", "moos", "mavlink")}
    data["tracker"] = {"planner": {"lead_times_s": [5.0]}}
    nav = data["nav"]
    nav["can"] = {"interface": "virtual"}
    if source == "dbc":
        nav["dbc"]["file"] = str(CONFIG / "sbg.dbc")
        nav["dbc"]["time"] = {"signal": nav["dbc"]["time"]}
        nav["dbc"]["signals"] = {name: {"signal": signal} for name, signal in nav["dbc"]["signals"].items()}
        nav["dbc"]["signals"]["latitude"]["plus"] = {"signal": "SBG_ECAN_MSG_EKF_POS.LATITUDE"}
        nav["dbc"]["held"] = {"SBG_ECAN_MSG_EKF_ALTITUDE": {}}
        nav["dbc"]["valid"][0]["accept"] = [0x30]
    elif source == "nmea":
        nav["nmea"]["accept"] = {"estimated": 10.0}
    elif source == "canopen":
        nav["canopen"] |= {name: str(CONFIG / nav["canopen"][name]) for name in ("ins_eds", "node_eds")}
        nav["canopen"]["objects"] = {name: {"field": field} for name, field in POSE_OBJECTS.items()}
        nav["canopen"]["status_bits"] = {"position": 0}
    return data


def bench(folder: Path) -> dict[str, Any]:
    data = tomllib.loads((CONFIG / "bench-faults.toml").read_text())
    data["onboard"] = str(CONFIG / "onboard.toml")
    with_planner = tomllib.loads((CONFIG / "bench-avoid.toml").read_text())
    data["planner"] = with_planner["planner"]
    data["limits"]["avoid"] = with_planner["limits"]["avoid"]
    data["sim"]["vehicle"] = with_planner["sim"]["vehicle"] | {"eds": str(CONFIG / "vehicle.eds")}
    return data


def put(table: Any, key: Key, value: float) -> None:
    for name in key[:-1]:
        table = table[first(table)] if name == ITEM else table.setdefault(name, {})
    table[first(table) if key[-1] == ITEM else key[-1]] = value


def first(table: Any) -> Any:
    return 0 if isinstance(table, list) else next(iter(table))


def make_worker(config: OnboardConfig, key: Key) -> None:
    counters: Counter[str] = Counter()
    service = cast(Service, SimpleNamespace(counters=counters, answer=None, log_once=None))
    if key[0] == "sonar":
        worker = SonarWorker(service, part_of(config, SonarConfig))
        worker.start()
        assert counters["port_open_errors"] == 1
        worker._protocol.connected(0)
        worker._protocol.requests(0)
    elif key[0] == "nav":
        NavWorker(service, part_of(config, NavConfig))


def complaint(file: Path, kind: type[Settings], key: Key) -> str:
    try:
        config = load(file, kind)
        if isinstance(config, OnboardConfig):
            make_worker(config, key)
    except OdsError as error:
        return str(error)
    return ""


def config_of(key: Key, folder: Path, kind: type[Settings]) -> dict[str, Any]:
    return (
        bench(folder)
        if kind is BenchConfig
        else onboard(folder, next((name for name in ("dbc", "nmea") if name in key), "canopen"))
    )


@pytest.mark.parametrize(
    ("kind", "key"),
    [(kind, key) for kind in (OnboardConfig, BenchConfig) for key in keys_of(kind)],
    ids=lambda part: ".".join(part) if isinstance(part, tuple) else part.__name__,
)
def test_an_absurd_number_loads_or_is_one_line_that_names_its_key(
    tmp_path: Path, kind: type[Settings], key: Key
) -> None:
    file = tmp_path / "config.toml"
    named = [name for name in key if name != ITEM][-1]
    shipped = config_of(key, tmp_path, kind)
    for value in ABSURD:
        put(data := deepcopy(shipped), key, value)
        file.write_text(tomli_w.dumps(data))
        said = complaint(file, kind, key).removeprefix(str(file))
        assert not said or (named in said and "\n" not in said), value
