"""`ods map`: list, export, merge and prune the maps that trackers leave. Reading works while a tracker runs."""

import os
import sqlite3
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from ods.base import clock
from ods.base.errors import OdsError
from ods.base.geodesy import LocalFrame
from ods.base.settings_file import load
from ods.config import OnboardConfig
from ods.map.export import points_of, utc_text, write_geojson, write_geopackage
from ods.map.merge import Spread, merge, moved
from ods.map.prune import Criteria, why_not
from ods.tracker.map.hibernated import MapObject
from ods.tracker.map.store import MapStore, copy_of_map, open_map, sole_access
from ods.tracker.settings import TrackerSettings

Area = tuple[float, float, float]
"""North, east and distance, m."""
Writer = Callable[[Path, list[MapObject], LocalFrame], None]
WRITERS: dict[str, Writer] = {".geojson": write_geojson, ".json": write_geojson, ".gpkg": write_geopackage}


def list_objects(file: Path | None, config: Path, within: Area | None = None) -> None:
    """Print a table of the objects. Raises OdsError."""
    objects, frame = _read(_map_file(file, config), within)
    print(
        f"{'id':>6} {'north m':>9} {'east m':>9} {'down m':>7} {'latitude':>12} {'longitude':>12} {'sigma N/E/D m':>16}"
        f" {'radius m':>13} {'exists':>6} {'seen':>5}  last seen (UTC)"
    )
    for o, (longitude, latitude, _) in zip(objects, points_of(objects, frame), strict=True):
        north, east, down = o.position
        sigma = "/".join(f"{value:.2f}" for value in o.sigma)
        radius = f"{o.radius:.2f} +-{o.sigma_radius:.2f}"
        print(
            f"{o.id:6d} {north:9.2f} {east:9.2f} {down:7.2f} {latitude:12.7f} {longitude:12.7f} {sigma:>16}"
            f" {radius:>13} {o.existence:6.3f} {o.times_seen:5d}  {utc_text(o.last_seen_utc_ns)}"
        )
    print(f"{len(objects)} objects; origin {frame.latitude_deg}, {frame.longitude_deg}")


def export(file: Path | None, config: Path, out: Path, within: Area | None = None) -> None:
    """Write the objects as geographic data; the suffix of `out` names the format. Raises OdsError."""
    if out.suffix.lower() not in WRITERS:
        raise OdsError(f"{out}: the suffix names the format: {', '.join(WRITERS)}")
    objects, frame = _read(_map_file(file, config), within)
    with _new_file(out) as part:
        WRITERS[out.suffix.lower()](part, objects, frame)
    print(f"{len(objects)} objects in {out}")


def merge_maps(first: Path, second: Path, out: Path, config: Path | None) -> None:
    """Write the map `out` that holds what both maps hold; neither of them is changed. Raises OdsError."""
    if out.exists():
        raise OdsError(f"{out}: exists already; a merged map is a new file")
    settings = load(config, OnboardConfig).tracker if config else TrackerSettings()
    with _opened(copy_of_map(first)) as one, _opened(copy_of_map(second)) as two:
        origin = one.origin_deg()
        others = moved(two.load(), LocalFrame(*two.origin_deg()), LocalFrame(*origin))
        spread = Spread(settings.map.position_sigma_m, settings.planner.shape_sigma)
        count = len(one.load())
        result = merge(one.load(), others, one.first_free_id(), spread)
    with _new_file(out) as part, _opened(open_map(part, *origin)) as store:
        store.change(result.objects, [])
        store.reserve(result.next_id)
    for own, other in result.pairs:
        print(f"{own} is {other} of {second}")
    print(f"{count} and {len(others)} objects, {len(result.pairs)} of them the same: {len(result.objects)} in {out}")


def prune(file: Path | None, config: Path, criteria: Criteria, *, dry_run: bool) -> None:
    """Take objects out of a map that no tracker is using, and say which and why. Raises OdsError."""
    if not criteria:
        raise OdsError("say what is to go: --existence-below, --older-than, --seen-fewer or --outside")
    path = _map_file(file, config)
    now_ns = clock.utc_ns()
    with _opened(copy_of_map(path) if dry_run else sole_access(path)) as store:
        objects = store.load()
        reasons = {o.id: why for o in objects if (why := why_not(o, criteria, now_ns))}
        store.change([], reasons)
    for object_id, why in reasons.items():
        print(f"{object_id}: {', '.join(why)}")
    print(f"{len(reasons)} of {len(objects)} objects {'would be removed' if dry_run else 'removed'} from {path}")


def _map_file(file: Path | None, config: Path) -> Path:
    """Return the map that was named, or else the configuration's."""
    path = file or load(config, OnboardConfig).tracker.map.path
    if path is None:
        raise OdsError(f"{config}: tracker.map.path is not set; name the map's file")
    return path


def _read(path: Path, within: Area | None) -> tuple[list[MapObject], LocalFrame]:
    with _opened(copy_of_map(path)) as store:
        return store.load(within), LocalFrame(*store.origin_deg())


@contextmanager
def _opened(store: MapStore) -> Iterator[MapStore]:
    try:
        yield store
    finally:
        store.close()


@contextmanager
def _new_file(out: Path) -> Iterator[Path]:
    """Give a file beside `out` to be written, which takes its name when it is whole."""
    part = out.with_name(f"{out.name}.{os.getpid()}.part")
    try:
        yield part
        part.replace(out)
    except (OSError, sqlite3.Error) as error:
        raise OdsError(f"{out}: {error}") from error
    finally:
        part.unlink(missing_ok=True)
