"""The project's own file of pings, .npz: one array for all frames, the geometry once. Format in docs/formats.md."""

import math
import zipfile
import zlib
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ods.messages import Ping, Scale, frame_of
from ods.sonar_link.files import polar_npz
from ods.sonar_link.files.ping_sequence import LazyPings, PingFileError, PingSequence
from ods.sonar_link.ping_builder import BeamTable, Geometry, build_ping, make_beam_table

NS = 1_000_000_000
LOG_FACTOR = 40.0
"""F of scale `log8` when the file does not tell it."""

Arrays = dict[str, NDArray[np.generic]]


def read_ping_file(path: Path) -> PingSequence:
    """Read a .npz file of pings. Raises PingFileError."""
    arrays = _load(path)
    try:
        return _sequence(polar_npz.translate(arrays))
    except ValueError as error:
        raise PingFileError(f"{path}: {error}") from error


def write_ping_file(
    path: Path,
    pings: Sequence[Ping],
    position_ned: ArrayLike | None = None,
    attitude: ArrayLike | None = None,
    truth: ArrayLike | None = None,
) -> None:
    """Write pings of one geometry, and what is given of vehicle poses (P, 3), (P, 4) and object truth (P, N, 7).

    Times are left out when all are the same: then nothing is known of them. Raises ValueError when the pings differ in
    geometry or there is none, OSError when the file cannot be written.
    """
    if not pings:
        raise ValueError("no ping to write")
    first = pings[0]
    if any(_shape_of(ping) != _shape_of(first) for ping in pings):
        raise ValueError("the pings differ in geometry: one .npz holds one geometry")
    arrays: dict[str, ArrayLike] = {
        "frames": np.stack([frame_of(ping) for ping in pings]),
        "bearing_rad": first.bearing_rad,
        "range0_m": first.range0_m,
        "dr_m": first.dr_m,
        "scale": f"log8:{first.scale_factor!r}" if first.scale == "log8" else first.scale,
        "sound_speed": first.sound_speed,
    }
    if len({ping.t_ns for ping in pings}) > 1:
        arrays["t"] = np.array([ping.t_ns for ping in pings]) / NS
    if first.scale == "db":
        arrays["db_per_count"] = first.scale_factor
    if first.frequency_hz:
        arrays["frequency_hz"] = first.frequency_hz
    if first.elevation_rad:
        arrays["elevation_rad"] = first.elevation_rad
    if first.beam_width_rad:
        arrays["beam_width_rad"] = first.beam_width_rad
    given = {"pos_ned": position_ned, "quat": attitude, "truth": truth}
    arrays.update({name: array for name, array in given.items() if array is not None})
    with path.open("wb") as file:
        np.savez(file, allow_pickle=False, **{name: np.asarray(array) for name, array in arrays.items()})


class _Shape(NamedTuple):
    """What all pings of a file have in common."""

    beams: int
    samples: int
    dtype: str
    bearing_rad: list[float]
    elevation_rad: list[float]
    range0_m: float
    dr_m: float
    sound_speed: float
    scale: str
    scale_factor: float


def _shape_of(ping: Ping) -> _Shape:
    return _Shape(*(getattr(ping, name) for name in _Shape._fields))


def _load(path: Path) -> Arrays:
    try:
        if not zipfile.is_zipfile(path):
            raise ValueError("no zip archive, or cut off")
        with np.load(path, allow_pickle=False) as file:
            return {name: np.asarray(file[name]) for name in file.files}
    except OSError as error:
        raise PingFileError(f"{path}: {error.strerror or error}") from error
    except (ValueError, EOFError, KeyError, MemoryError, zipfile.BadZipFile, zlib.error, NotImplementedError) as error:
        raise PingFileError(f"{path}: not a whole .npz file: {error}") from error


def _sequence(arrays: Arrays) -> PingSequence:
    bearing = _numbers(arrays, "bearing_rad", 1)
    elevation = _numbers(arrays, "elevation_rad", 1) if "elevation_rad" in arrays else np.zeros(bearing.size)
    width = _numbers(arrays, "beam_width_rad", 1) if "beam_width_rad" in arrays else np.empty(0)
    table = make_beam_table(bearing, elevation, width)
    frames = _frames(arrays, table)
    scale, factor = _scale(arrays)
    geometry = Geometry(
        table=table,
        range0_m=_number(arrays, "range0_m"),
        dr_m=_number(arrays, "dr_m"),
        sound_speed=_number(arrays, "sound_speed", 1500.0),
        frequency_hz=_number(arrays, "frequency_hz", 0.0),
        scale=scale,
        scale_factor=factor,
    )
    times_ns = _times_ns(arrays, len(frames))

    def make(index: int) -> Ping:
        t_ns = times_ns[index]
        return build_ping(
            frames[index], geometry, seq=index, ping_number=index, t_ns=t_ns, t_rx_ns=t_ns, utc_ns=t_ns
        )  # fmt: skip

    make(0)  # what is wrong with one is wrong with all
    position, attitude = _poses(arrays, len(frames))
    return PingSequence(
        pings=LazyPings(len(frames), make),
        timed="t" in arrays,
        position_ned=position,
        attitude=attitude,
        truth=_truth(arrays, len(frames)),
    )


def _frames(arrays: Arrays, table: BeamTable) -> NDArray[np.generic]:
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
    raise ValueError(f"scale: {text!r} is none of 'linear', 'db', 'log8:F'")


def _times_ns(arrays: Arrays, count: int) -> list[int]:
    if "t" not in arrays:
        return [0] * count
    t = _numbers(arrays, "t", 1)
    if t.size != count or not np.isfinite(t).all() or np.any(np.diff(t) <= 0.0) or np.any(np.abs(t) > 9e9):
        raise ValueError(f"t: must be {count} rising times, s")
    return [round(seconds * NS) for seconds in t.tolist()]


def _poses(arrays: Arrays, count: int) -> tuple[NDArray[np.float64] | None, NDArray[np.float64] | None]:
    if "pos_ned" not in arrays and "quat" not in arrays:
        return None, None
    position, attitude = _numbers(arrays, "pos_ned", 2), _numbers(arrays, "quat", 2)
    if position.shape != (count, 3) or not np.isfinite(position).all():
        raise ValueError(f"pos_ned: must be {count} x 3 finite numbers")
    norm = np.linalg.norm(attitude, axis=-1, keepdims=True)
    if attitude.shape != (count, 4) or not np.all(np.abs(norm - 1.0) < 1e-3):
        raise ValueError(f"quat: must be {count} unit quaternions")
    return position, attitude / norm


def _truth(arrays: Arrays, count: int) -> NDArray[np.float64] | None:
    if "truth" not in arrays:
        return None
    truth = _numbers(arrays, "truth", 3)
    if truth.shape[0] != count or truth.shape[2] != 7:
        raise ValueError(f"truth: shape {truth.shape} is not ({count}, objects, 7)")
    return truth


def _array(arrays: Arrays, name: str) -> NDArray[np.generic]:
    if name not in arrays:
        raise ValueError(f"no array `{name}`")
    return arrays[name]


def _numbers(arrays: Arrays, name: str, dimensions: int) -> NDArray[np.float64]:
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
