"""Writes points as an OGC GeoPackage (OGC 12-128r19, version 1.3), one SQLite file that GIS programs open.

Why not GDAL: docs/decisions/0005-geopackage-by-sqlite.md.
"""

import sqlite3
import struct
from collections.abc import Sequence
from pathlib import Path

APPLICATION_ID = 0x47504B47
"""`GPKG`."""
VERSION = 10300
WGS84_SRS, WGS84_3D_SRS = 4326, 4979
"""EPSG codes. The points have heights above the ellipsoid, as GeoJSON's have: readers take that for the latter."""
WGS84_WKT = (
    'GEOGCS["WGS 84",DATUM["World Geodetic System 1984",SPHEROID["WGS 84",6378137,298.257223563,'
    'AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0,AUTHORITY["EPSG","8901"]],'
    'UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AUTHORITY["EPSG","4326"]]'
)
WGS84_3D_WKT = (
    'GEOGCS["WGS 84",DATUM["World Geodetic System 1984",SPHEROID["WGS 84",6378137,298.257223563,'
    'AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0,AUTHORITY["EPSG","8901"]],'
    'UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AXIS["Latitude",NORTH],AXIS["Longitude",EAST],'
    'AXIS["Ellipsoidal height",UP],AUTHORITY["EPSG","4979"]]'
)
SCHEMA = """
CREATE TABLE gpkg_spatial_ref_sys (
    srs_name TEXT NOT NULL, srs_id INTEGER PRIMARY KEY, organization TEXT NOT NULL,
    organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT
);
CREATE TABLE gpkg_contents (
    table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE, description TEXT DEFAULT '',
    last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ', 'now')),
    min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER,
    CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id)
);
CREATE TABLE gpkg_geometry_columns (
    table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL, srs_id INTEGER NOT NULL,
    z TINYINT NOT NULL, m TINYINT NOT NULL,
    CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name),
    CONSTRAINT uk_gc_table_name UNIQUE (table_name),
    CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name),
    CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id)
);
"""
SYSTEMS = (
    ("Undefined Cartesian", -1, "NONE", -1, "undefined", None),
    ("Undefined geographic", 0, "NONE", 0, "undefined", None),
    ("WGS 84 geodetic", WGS84_SRS, "EPSG", WGS84_SRS, WGS84_WKT, "longitude and latitude in degrees"),
    ("WGS 84 3D", WGS84_3D_SRS, "EPSG", WGS84_3D_SRS, WGS84_3D_WKT, "and height above the ellipsoid in metres"),
)


def write_points(
    path: Path,
    table: str,
    fields: dict[str, str],
    points: Sequence[tuple[float, float, float]],
    rows: Sequence[Sequence[object]],
) -> None:
    """Write a new file with one layer of 3-D points.

    fields: SQL type of each attribute, the first one the feature id; points: longitude, latitude in deg, height in m;
    rows: the attributes of each point. Raises sqlite3.Error.
    """
    db = sqlite3.connect(path, isolation_level=None)
    try:
        db.executescript(f"PRAGMA application_id = {APPLICATION_ID}; PRAGMA user_version = {VERSION};")
        db.executescript(f"BEGIN; {SCHEMA}")
        db.executemany("INSERT INTO gpkg_spatial_ref_sys VALUES (?, ?, ?, ?, ?, ?)", SYSTEMS)
        (key, _), *others = fields.items()
        columns = ", ".join(f"{name} {kind}" for name, kind in others)
        db.execute(f"CREATE TABLE {table} ({key} INTEGER PRIMARY KEY NOT NULL, geom POINT, {columns})")
        extent = (None,) * 4
        if points:
            x, y, _ = zip(*points, strict=True)
            extent = (min(x), min(y), max(x), max(y))
        db.execute(
            "INSERT INTO gpkg_contents (table_name, data_type, identifier, min_x, min_y, max_x, max_y, srs_id)"
            " VALUES (?, 'features', ?, ?, ?, ?, ?, ?)",
            (table, table, *extent, WGS84_3D_SRS),
        )
        db.execute("INSERT INTO gpkg_geometry_columns VALUES (?, 'geom', 'POINT', ?, 1, 0)", (table, WGS84_3D_SRS))
        marks = ", ".join("?" * (len(fields) + 1))
        filled = ((row[0], point_blob(*point), *row[1:]) for point, row in zip(points, rows, strict=True))
        db.executemany(f"INSERT INTO {table} VALUES ({marks})", filled)
        db.execute("COMMIT")
    finally:
        db.close()


def point_blob(x: float, y: float, z: float) -> bytes:
    """Return a point in the GeoPackage's binary form: header without envelope, then ISO WKB, all little endian."""
    header = struct.pack("<2sBBi", b"GP", 0, 0b00000001, WGS84_3D_SRS)
    return header + struct.pack("<BI3d", 1, 1001, x, y, z)
