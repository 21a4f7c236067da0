"""Recordings: the project's .npz, .s7k, SoundMetrics .aris, Blueprint Oculus .raw; whole, cut off and absurd."""

import struct
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike, NDArray
from s7k_tables import entries_of
from sonar_samples import UTC_NS, make_ping

from ods.messages import Ping, SampleType, Scale, frame_of
from ods.sonar_link.drf import encode_record
from ods.sonar_link.files.npz import write_ping_file
from ods.sonar_link.files.opening import PingFileError, open_pings
from ods.sonar_link.files.s7k_catalogue import encode_file_header
from ods.sonar_link.files.s7k_file import write_s7k

DATA = Path(__file__).parent / "data"
ARIS = DATA / "aris" / "sample.aris"
OCULUS = DATA / "oculus" / "three_pings_8bit.raw"

Arrays = dict[str, ArrayLike]


def standard() -> Arrays:
    """A file that has everything, as docs/formats.md says."""
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


def edited(path: Path, source: Path, edit: Callable[[bytearray], object]) -> Path:
    data = bytearray(source.read_bytes())
    edit(data)
    path.write_bytes(data)
    return path


def same_but(a: Ping, b: Ping, *fields: str) -> bool:
    return all(getattr(a, name) == getattr(b, name) for name in Ping.__struct_fields__ if name not in fields)


# --- .npz


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
        ("truth", np.zeros((2, 1, 6)), "truth: shape"),
        ("truth", np.array([[["a"]]]), "truth: not an array of numbers"),
        ("dr_m", np.array({"a": 1}), "not a whole .npz file"),
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
    for pings in ([], [make_ping(0), make_ping(1, samples=41)]):
        with pytest.raises(ValueError, match="ping"):
            write_ping_file(tmp_path / "pings.npz", pings)


# --- .s7k


def test_s7k_round_trip_with_foreign_records_and_a_cut_off_end(tmp_path: Path) -> None:
    path = tmp_path / "line.s7k"
    pings = [make_ping(n, utc_ns=UTC_NS + n * 250_000_000, samples=40 + n) for n in range(4)]
    write_s7k(path, pings)
    last = entries_of(path)[-1]
    data = path.read_bytes()[: last["offset"] + last["size"] - 7]
    assert data[4:8] == b"\xff\xff\x00\x00"
    path.write_bytes(data + encode_record(1003, bytes(37), UTC_NS, 100))
    sequence = open_pings(path)
    assert [same_but(a, b, "t_rx_ns") for a, b in zip(sequence.pings, pings[:3], strict=True)] == [True] * 3
    assert sequence.losses["bad_checksum"] == 1
    assert sequence.losses["other_records"] == 2
    assert sequence.timed


def test_s7k_without_pings_says_what_is_in_it(tmp_path: Path) -> None:
    path = tmp_path / "empty.s7k"
    path.write_bytes(encode_file_header(UTC_NS, "empty") + b"noise")
    with pytest.raises(PingFileError, match=r"no ping in it \(garbage_bytes 5, other_records 1, records 1\)"):
        open_pings(path)


# --- .aris


def test_aris_samples_beams_and_ranges() -> None:
    sequence = open_pings(ARIS)
    raw = ARIS.read_bytes()
    assert len(sequence.pings) == 6
    assert not sequence.losses
    ping = sequence.pings[2]
    frame_at = 1024 + 2 * (1024 + 2000 * 48) + 1024
    assert [frame_of(ping)[47, 0], frame_of(ping)[0, 0], frame_of(ping)[46, 1999]] == [
        raw[frame_at], raw[frame_at + 47], raw[frame_at + 1999 * 48 + 1]
    ]  # fmt: skip
    # 4593 us delay and 14 us a sample at 1435.933 m/s
    assert (ping.range0_m, ping.dr_m) == pytest.approx((3.297621, 0.01005153), rel=1e-6)
    assert (ping.scale, ping.scale_factor, ping.frequency_hz) == ("db", 80 / 255, 1.2e6)
    assert [p.t_ns for p in sequence.pings][:2] == [1371198079122519000, 1371198079274984000]
    # beam centres of the telephoto lens as its maker publishes them, degrees
    bearing = np.degrees(ping.bearing_rad)
    assert bearing[[0, 1, 12, 23, 24, 47]] == pytest.approx([-7.339, -7.043, -3.659, -0.160, 0.160, 7.339], abs=0.004)
    assert np.all(np.diff(bearing) > 0.28)


def test_aris_cut_off_and_corrupt(tmp_path: Path) -> None:
    frame = 1024 + 2000 * 48

    def spoil(data: bytearray) -> None:
        data[1024 + 1 * frame + 12] = 0  # signature
        struct.pack_into("<f", data, 1024 + 2 * frame + 464, float("nan"))  # sound speed
        struct.pack_into("<I", data, 1024 + 3 * frame + 468, 2**32 - 1)  # samples
        struct.pack_into("<I", data, 1024 + 4 * frame + 452, 0)  # sample period
        del data[-100:]

    sequence = open_pings(edited(tmp_path / "bad.aris", ARIS, spoil))
    assert [p.t_ns for p in sequence.pings] == [1371198079122519000]
    assert sequence.losses == {"corrupt_frames": 4, "truncated_frames": 1}


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda data: data.__delitem__(slice(1500, None)), "not an ARIS recording"),
        (lambda data: data.__delitem__(slice(5000, None)), "no whole frame"),
        (lambda data: struct.pack_into("<I", data, 1024 + 468, 2**32 - 1), "first frame header is corrupt"),
        (lambda data: struct.pack_into("<I", data, 1024 + 436, 77), "first frame header is corrupt"),
        (lambda data: struct.pack_into("<I", data, 1024 + 436, 6), "first frame header is corrupt"),
    ],
)
def test_aris_errors(tmp_path: Path, edit: Callable[[bytearray], object], message: str) -> None:
    with pytest.raises(PingFileError, match=message):
        open_pings(edited(tmp_path / "bad.aris", ARIS, edit))


# --- Oculus


def raw_oculus(index: int) -> NDArray[np.uint8]:
    """The samples of one message, beam by beam: 703 lines of 256 beams at byte 2048 of 182016."""
    return np.fromfile(OCULUS, np.uint8, 703 * 256, offset=index * 182016 + 2048).reshape(703, 256).T


def test_oculus_samples_beams_and_ranges() -> None:
    sequence = open_pings(OCULUS)
    assert [p.ping_number for p in sequence.pings] == [415323, 415324, 415325]
    assert not sequence.losses
    assert not sequence.timed
    ping = sequence.pings[1]
    # the sonar sent the power 127/255 of the amplitude
    expected = 255.0 * (raw_oculus(1) / 255.0) ** (255 / 127)
    np.testing.assert_allclose(frame_of(ping).astype(np.float64), expected, rtol=1e-6)
    assert (ping.scale, ping.dtype, ping.beams, ping.samples) == ("linear", "f4", 256, 703)
    assert np.degrees(ping.bearing_rad)[[0, 1, 255]] == pytest.approx([-30.0, -29.74, 30.0])
    assert ping.dr_m == pytest.approx(2.84219e-3, rel=1e-5)
    assert ping.range0_m == pytest.approx(ping.dr_m / 2)
    assert (ping.sound_speed, ping.frequency_hz) == pytest.approx((1490.6586, 2.0988806e6))


def test_oculus_without_gamma_stays_8_bit(tmp_path: Path) -> None:
    path = edited(tmp_path / "plain.raw", OCULUS, lambda data: data.__setitem__(16 + 3, 255))
    ping = open_pings(path).pings[0]
    assert ping.dtype == "u1"
    assert frame_of(ping).tolist() == raw_oculus(0).tolist()


def test_oculus_cut_off_corrupt_and_foreign(tmp_path: Path) -> None:
    def spoil(data: bytearray) -> None:
        struct.pack_into("<H", data, 182016 + 106, 65535)  # lines of the second ping
        data[2 * 182016 : 2 * 182016] = struct.pack("<2sHHHHIH", b"SO", 0, 0, 0x55, 0, 12, 0) + bytes(12) + b"noise"
        del data[-5:]

    sequence = open_pings(edited(tmp_path / "bad.raw", OCULUS, spoil))
    assert [p.ping_number for p in sequence.pings] == [415323]
    assert sequence.losses["corrupt_pings"] == 1
    assert sequence.losses["other_messages"] == 1
    assert sequence.losses["garbage_bytes"] == 5 + 182016 - 5


@pytest.mark.parametrize(
    ("offset", "value"),
    [
        (106, 0), (106, 65535), (108, 0), (108, 65535),  # lines, beams
        (110, 2**32 - 1), (110, 0), (114, 2**32 - 1),  # image offset, image size
        (97, 7), (104, 0x7FF8), (122, 9000),  # sample size, line spacing (to NaN), first bearing (to 90 degrees)
    ],
)  # fmt: skip
def test_oculus_absurd_sizes(tmp_path: Path, offset: int, value: int) -> None:
    def spoil(data: bytearray) -> None:
        del data[182016:]
        struct.pack_into("<I" if offset in (110, 114) else "<H" if offset != 97 else "<B", data, offset, value)

    with pytest.raises(PingFileError, match="no whole simple ping result"):
        open_pings(edited(tmp_path / "bad.raw", OCULUS, spoil))


# --- any


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("missing.npz", None, "No such file"),
        ("empty.npz", b"", "the file is empty"),
        ("cut.npz", b"PK\x03\x04 and then nothing", "not a whole .npz file"),
        ("text.npz", b"not a zip archive at all", "not a whole .npz file"),
        ("text.s7k", b"not a recording at all", "no ping in it"),
        ("text.aris", b"not a recording at all", "not an ARIS recording"),
        ("text.raw", b"not a recording at all", "no whole simple ping result"),
        ("clip.avi", b"RIFF and so on", "none of the known formats"),
    ],
)
def test_any_other_file_is_one_clear_line(tmp_path: Path, name: str, content: bytes | None, message: str) -> None:
    path = tmp_path / name
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(PingFileError, match=message) as caught:
        open_pings(path)
    assert str(caught.value).startswith(f"{path}: ")
    assert "\n" not in str(caught.value)


def test_a_folder_is_no_recording(tmp_path: Path) -> None:
    with pytest.raises(PingFileError, match="Is a directory"):
        open_pings(tmp_path)
