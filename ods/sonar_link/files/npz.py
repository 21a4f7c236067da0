"""The project's own file of pings, .npz: one array of all frames, one geometry. Format: docs/recordings/formats.md."""

import math
from collections import defaultdict
from pathlib import Path

import numpy as np

from ods.base.arrays import AnyArray, Floats
from ods.base.clock import NS
from ods.base.files.npz_file import load_npz
from ods.messages import Ping, Scale
from ods.sonar_link.files.decoder import Decoder
from ods.sonar_link.files.ping_sequence import FARTHEST_M, LazyPings, PingFileError, PingSequence, recorded_ping
from ods.sonar_link.files.polar_npz import Arrays, translate
from ods.sonar_link.ping_builder import BeamTable, Geometry, Runs, make_beam_table

LOG_FACTOR = 40.0
"""F of scale `log8` when the file does not report it."""


class NpzDecoder(Decoder):
    """All or nothing: a file of which anything is wrong is an error."""

    name = ".npz"
    signature = ((0, b"PK"),)
    suffix = ".npz"

    def read(self, path: Path) -> PingSequence:
        """Read a file of pings. Raises PingFileError."""
        arrays = _load(path)
        try:
            return _sequence(translate(arrays))
        except ValueError as error:
            raise PingFileError(f"{path}: {error}") from error


def _load(path: Path) -> Arrays:
    try:
        return load_npz(path)
    except OSError as error:
        raise PingFileError(f"{path}: {error.strerror or error}") from error
    except ValueError as error:
        raise PingFileError(f"{path}: {error}") from error


def _sequence(arrays: Arrays) -> PingSequence:
    table = _table(arrays)
    frames = _frames(arrays, table)
    geometry = _geometry(arrays, table)
    times_ns = _times_ns(arrays, len(frames))

    no_data = _no_data(arrays, frames.shape)

    def make(index: int) -> Ping:
        return recorded_ping(frames[index], geometry, index, times_ns[index], no_data=no_data.get(index))

    make(0)  # what is wrong with one is wrong with all
    position, attitude = _poses(arrays, len(frames))
    return PingSequence(
        pings=LazyPings(len(frames), make),
        timed="t" in arrays,
        position_ned=position,
        attitude=attitude,
        truth=_truth(arrays, len(frames)),
    )


def _table(arrays: Arrays) -> BeamTable:
    bearing = _numbers(arrays, "bearing_rad", 1)
    elevation = _numbers(arrays, "elevation_rad", 1) if "elevation_rad" in arrays else np.zeros(bearing.size)
    width = _numbers(arrays, "beam_width_rad", 1) if "beam_width_rad" in arrays else np.empty(0)
    return make_beam_table(bearing, elevation, width)


def _geometry(arrays: Arrays, table: BeamTable) -> Geometry:
    scale, factor = _scale(arrays)
    return Geometry(
        table=table,
        range0_m=_number(arrays, "range0_m"),
        dr_m=_number(arrays, "dr_m"),
        sound_speed=_number(arrays, "sound_speed", 1500.0),
        frequency_hz=_number(arrays, "frequency_hz", 0.0),
        scale=scale,
        scale_factor=factor,
    )


def _frames(arrays: Arrays, table: BeamTable) -> AnyArray:
    frames = _array(arrays, "frames")
    beams = table.bearing_rad.size
    if frames.ndim != 3 or 0 in frames.shape:
        raise ValueError(f"frames: shape {frames.shape} is not (pings, beams, samples)")
    if frames.shape[1] != beams:
        if frames.shape[2] != beams:
            raise ValueError(f"frames: shape {frames.shape} does not fit {beams} bearings")
        frames = frames.transpose(0, 2, 1)  # sample by sample, which nothing else can be
    if frames.dtype.kind == "f" and not np.isfinite(frames).all():
        raise ValueError("frames: a sample is not a finite number")
    return frames


def _no_data(arrays: Arrays, shape: tuple[int, ...]) -> dict[int, Runs]:
    """Return the runs without data of each ping that has any; shape: (pings, beams, samples)."""
    if "no_data" not in arrays:
        return {}
    rows = _numbers(arrays, "no_data", 2)
    if rows.shape[1] != 4 or not np.all((rows >= 0.0) & (rows <= [shape[0] - 1, shape[1] - 1, shape[2] - 1, shape[2]])):
        raise ValueError("no_data: must be rows of ping, beam, first and stop within the frames")
    runs: defaultdict[int, Runs] = defaultdict(list)
    for index, beam, first, stop in rows.astype(np.int64).tolist():
        runs[index].append((beam, first, stop))
    return dict(runs)


def _scale(arrays: Arrays) -> tuple[Scale, float]:
    text = str(_array(arrays, "scale")[()])
    name, _, factor = text.partition(":")
    if name == "linear" and not factor:
        return "linear", 1.0
    if name == "db" and not factor:
        return "db", _number(arrays, "db_per_count")
    if name == "log8":
        try:
            return "log8", float(factor or LOG_FACTOR)
        except ValueError:
            pass
    raise ValueError(f"scale: {text!r} is not one of 'linear', 'db', 'log8:F'")


def _times_ns(arrays: Arrays, count: int) -> list[int]:
    if "t" not in arrays:
        return [0] * count
    t = _numbers(arrays, "t", 1)
    if t.size != count or not np.isfinite(t).all() or np.any(np.diff(t) <= 0.0) or np.any(np.abs(t) > 9e9):
        raise ValueError(f"t: must be {count} rising times, s")
    return [round(seconds * NS) for seconds in t.tolist()]


def _poses(arrays: Arrays, count: int) -> tuple[Floats | None, Floats | None]:
    if "pos_ned" not in arrays and "quat" not in arrays:
        return None, None
    position, attitude = _numbers(arrays, "pos_ned", 2), _numbers(arrays, "quat", 2)
    if position.shape != (count, 3) or not np.isfinite(position).all():
        raise ValueError(f"pos_ned: must be {count} x 3 finite numbers")
    if (np.abs(position) > FARTHEST_M).any():
        raise ValueError(f"pos_ned: a position is farther than {FARTHEST_M:g} m from the origin")
    attitude = np.clip(attitude, -2.0, 2.0)  # or the norm of absurd ones overflows
    norm = np.linalg.norm(attitude, axis=-1, keepdims=True)
    if attitude.shape != (count, 4) or not np.all(np.abs(norm - 1.0) < 1e-3):
        raise ValueError(f"quat: must be {count} unit quaternions")
    return position, attitude / norm


def _truth(arrays: Arrays, count: int) -> Floats | None:
    if "truth" not in arrays:
        return None
    truth = _numbers(arrays, "truth", 3)
    if truth.shape[0] != count or truth.shape[2] != 7:
        raise ValueError(f"truth: shape {truth.shape} is not ({count}, objects, 7)")
    return truth


def _array(arrays: Arrays, name: str) -> AnyArray:
    if name not in arrays:
        raise ValueError(f"no array `{name}`")
    return arrays[name]


def _numbers(arrays: Arrays, name: str, dimensions: int) -> Floats:
    array = _array(arrays, name)
    if array.dtype.kind not in "fiu" or array.ndim != dimensions:
        raise ValueError(f"{name}: not an array of numbers with {dimensions} dimension{'s' if dimensions > 1 else ''}")
    return array.astype(np.float64)


def _number(arrays: Arrays, name: str, default: float = math.nan) -> float:
    if name not in arrays and not math.isnan(default):
        return default
    array = _array(arrays, name)
    if array.dtype.kind not in "fiu" or array.size != 1:
        raise ValueError(f"{name}: not a number")
    return float(array.reshape(-1)[0])
