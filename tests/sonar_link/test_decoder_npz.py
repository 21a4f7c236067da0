"""The project's own pings, .npz: everything, the least, what is wrong, and arrays saved by others."""

import struct
import zipfile
from pathlib import Path

import msgspec
import numpy as np
import pytest
from numpy.typing import ArrayLike

from ods.messages import SampleType, Scale, frame_of
from ods.sonar_link.files.npz_writer import write_ping_file
from ods.sonar_link.files.opening import PingFileError, open_pings
from tests.recordings import same_but
from tests.sonar_link.sonar_samples import make_ping

Arrays = dict[str, ArrayLike]


def standard() -> Arrays:
    """A file that has everything, as docs/recordings/formats.md says."""
    return {
        "frames": np.arange(2 * 3 * 5, dtype=np.uint8).reshape(2, 3, 5),
        "t": [10.0, 10.15],
        "bearing_rad": [-0.2, 0.0, 0.3],
        "range0_m": 0.5,
        "dr_m": 0.05,
        "scale": "log8:30",
        "sound_speed": 1490.0,
        "frequency_hz": 455e3,
        "pos_ned": np.zeros((2, 3)),
        "quat": [[1, 0, 0, 0], [0, 0, 0, 1]],
        "truth": np.full((2, 1, 7), np.nan),
    }


def save(path: Path, arrays: Arrays) -> Path:
    np.savez(path, allow_pickle=True, **{name: np.asarray(array) for name, array in arrays.items()})
    return path


def test_npz_with_everything(tmp_path: Path) -> None:
    sequence = open_pings(save(tmp_path / "pings.npz", standard()))
    first, second = sequence.pings
    assert frame_of(second).tolist() == np.arange(15, 30).reshape(3, 5).tolist()
    assert (first.t_ns, second.t_ns) == (10_000_000_000, 10_150_000_000)
    assert (first.scale, first.scale_factor, first.range0_m, first.dr_m) == ("log8", 30.0, 0.5, 0.05)
    assert (first.sound_speed, first.frequency_hz, first.bearing_rad) == (1490.0, 455e3, [-0.2, 0.0, 0.3])
    assert sequence.timed
    assert sequence.position_ned is not None
    assert sequence.position_ned.shape == (2, 3)
    assert sequence.attitude is not None
    assert sequence.attitude.shape == (2, 4)
    assert sequence.truth is not None
    assert sequence.truth.shape == (2, 1, 7)
    assert [ping.seq for ping in sequence.pings[1:]] == [1]


@pytest.mark.parametrize(
    ("scale", "more", "expected"),
    [
        ("linear", {}, ("linear", 1.0)),
        ("log8", {}, ("log8", 40.0)),
        ("db", {"db_per_count": 80 / 255}, ("db", 80 / 255)),
    ],
)
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16, np.float32])
def test_npz_of_single_images_in_all_scales_and_sample_types(
    tmp_path: Path, scale: str, more: Arrays, expected: tuple[str, float], dtype: type
) -> None:
    needed = ("bearing_rad", "range0_m", "dr_m")
    arrays: Arrays = {name: standard()[name] for name in needed}
    arrays.update({"frames": np.ones((1, 3, 5), dtype), "scale": scale}, **more)
    sequence = open_pings(save(tmp_path / "image.npz", arrays))
    (ping,) = sequence.pings
    assert (ping.scale, ping.scale_factor) == expected
    assert not sequence.timed
    assert frame_of(ping).tolist() == np.ones((3, 5)).tolist()


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("frames", None, "no array `frames`"),
        ("scale", None, "no array `scale`"),
        ("dr_m", None, "no array `dr_m`"),
        ("bearing_rad", None, "no array `bearing_rad`"),
        ("frames", np.zeros((2, 3)), "frames: shape"),
        ("frames", np.zeros((2, 4, 5), np.uint8), "frames: shape"),
        ("frames", np.zeros((0, 3, 5), np.uint8), "frames: shape"),
        ("frames", np.zeros((2, 3, 5), np.float64), "sample type float64"),
        ("frames", np.full((2, 3, 5), np.nan, np.float32), "not a finite number"),
        ("frames", np.zeros((2, 3, 70_000), np.uint8), "too large"),
        ("bearing_rad", [-0.2, 0.3, 0.3], "beam table"),
        ("bearing_rad", [-0.2, np.nan, 0.3], "beam table"),
        ("bearing_rad", ["a", "b", "c"], "bearing_rad: not an array of numbers"),
        ("range0_m", -1.0, "range0_m"),
        ("dr_m", 0.0, "dr_m"),
        ("dr_m", np.nan, "dr_m"),
        ("dr_m", [0.1, 0.2], "dr_m: not a number"),
        ("sound_speed", 5.0, "sound_speed"),
        ("scale", "db", "no array `db_per_count`"),
        ("scale", "log8:x", "scale: 'log8:x'"),
        ("scale", "log8:-1", "scale_factor"),
        ("scale", "power", "scale: 'power'"),
        ("t", [10.0], "t: must be 2 rising times"),
        ("t", [10.0, 10.0], "t: must be 2 rising times"),
        ("t", [10.0, np.nan], "t: must be 2 rising times"),
        ("quat", None, "no array `quat`"),
        ("quat", [[1, 0, 0, 0], [0, 0, 0, 0]], "quat: must be 2 unit quaternions"),
        ("pos_ned", [[0, 0, np.nan], [0, 0, 0]], "pos_ned: must be 2 x 3 finite numbers"),
        ("pos_ned", [[0, 0, 1e300], [0, 0, 0]], "pos_ned: a position is farther than"),
        ("quat", [[1e300, 0, 0, 0], [1, 0, 0, 0]], "quat: must be 2 unit quaternions"),
        ("truth", np.zeros((2, 1, 6)), "truth: shape"),
        ("truth", np.array([[["a"]]]), "truth: not an array of numbers"),
        ("dr_m", np.array({"a": 1}), "not a complete .npz file"),
    ],
)
def test_npz_errors_are_one_line_that_names_the_array(
    tmp_path: Path, name: str, value: ArrayLike | None, message: str
) -> None:
    arrays = standard()
    if value is None:
        del arrays[name]
    else:
        arrays[name] = value
    with pytest.raises(PingFileError, match=message) as caught:
        open_pings(save(tmp_path / "bad.npz", arrays))
    assert "\n" not in str(caught.value)
    assert "bad.npz" in str(caught.value)


@pytest.mark.parametrize(
    "header",
    [b"{'descr': '|u1', 'fortran_order': False, 'shape': (2, 3, 5", b"{'shape': (02,)}", b"(" * 5000, b" " * 20_000],
)
def test_npz_of_an_array_with_a_damaged_header(tmp_path: Path, header: bytes) -> None:
    path = tmp_path / "bad.npz"
    with zipfile.ZipFile(path, "w") as file:
        file.writestr("frames.npy", b"\x93NUMPY\x01\x00" + struct.pack("<H", len(header)) + header)
    with pytest.raises(PingFileError, match=r"not a complete \.npz file") as caught:
        open_pings(path)
    assert "\n" not in str(caught.value)


def test_npz_sample_by_sample_is_taken_where_nothing_else_fits(tmp_path: Path) -> None:
    arrays = standard()
    frames = np.asarray(arrays["frames"])
    arrays["frames"] = frames.transpose(0, 2, 1)
    pings = open_pings(save(tmp_path / "turned.npz", arrays)).pings
    assert frame_of(pings[1]).tolist() == frames[1].tolist()


def test_npz_under_other_names(tmp_path: Path) -> None:
    arrays: Arrays = {"frames": np.zeros((2, 5, 3), np.uint8), "bearings_deg": [-30.0, 0.0, 30.0], "dr": 0.01}
    arrays |= {"c": 1490.0, "freq": 2.1e6, "t_us": np.array([0, 150_000], np.uint64)}
    second = open_pings(save(tmp_path / "polar.npz", arrays)).pings[1]
    assert (second.beams, second.samples, second.dr_m, second.range0_m) == (3, 5, 0.01, 0.0)
    assert np.degrees(second.bearing_rad).tolist() == pytest.approx([-30.0, 0.0, 30.0])
    assert (second.t_ns, second.frequency_hz) == (150_000_000, 2.1e6)


@pytest.mark.parametrize(
    ("dtype", "scale", "factor"),
    [("u1", "log8", 40.0), ("u2", "linear", 1.0), ("f4", "linear", 1.0), ("u1", "db", 80 / 255)],
)
@pytest.mark.parametrize("planes", [1, 3])
def test_npz_round_trip(tmp_path: Path, dtype: SampleType, scale: Scale, factor: float, planes: int) -> None:
    pings = [
        make_ping(n, dtype=dtype, scale=scale, scale_factor=factor, planes=planes, utc_ns=n * 150_000_000 + 250_000_000)
        for n in range(3)
    ]
    write_ping_file(tmp_path / "pings.npz", pings, np.zeros((3, 3)), [[1, 0, 0, 0]] * 3, np.zeros((3, 2, 7)))
    sequence = open_pings(tmp_path / "pings.npz")
    assert all(same_but(a, b, "t_rx_ns") for a, b in zip(sequence.pings, pings, strict=True))
    assert sequence.truth is not None
    assert sequence.truth.shape == (3, 2, 7)


def test_npz_writer_refuses_pings_of_two_geometries(tmp_path: Path) -> None:
    second = make_ping(1)
    others = (
        make_ping(1, samples=41),
        msgspec.structs.replace(second, frequency_hz=2e5),
        msgspec.structs.replace(second, beam_width_rad=[]),
    )
    for pings in ([], *([make_ping(0), other] for other in others)):
        with pytest.raises(ValueError, match="ping"):
            write_ping_file(tmp_path / "pings.npz", pings)
