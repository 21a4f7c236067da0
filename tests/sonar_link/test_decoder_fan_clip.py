"""Clips of fan images: three codecs, the resampling, what is broken."""

import io
import re
import struct
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from ods import cli
from ods.base.arrays import AnyArray, Bytes
from ods.messages import frame_of
from ods.sonar_link.files.avi import AviFrames
from ods.sonar_link.files.fan_image import FanGeometry, sample_image
from ods.sonar_link.files.opening import PingFileError, open_pings

Pixels = Bytes
FAN = FanGeometry(
    apex_x_px=64.0, apex_y_px=140.0, pixels_per_m=25.0, bearing_min_deg=-15.0, bearing_max_deg=15.0,
    range_min_m=1.0, range_max_m=5.0, beams=30, samples=80,
)  # fmt: skip


def chunk(name: bytes, data: bytes) -> bytes:
    return name + struct.pack("<I", len(data)) + data + b"\0" * (len(data) % 2)


def clip(codec: bytes, bits: int, width: int, height: int, frames: list[bytes]) -> bytes:
    """An .avi clip of ten frames a second with a grey palette."""
    form = struct.pack("<IiiHH4s20x", 40, width, height, 1, bits, codec) + bytes(
        value for k in range(256) for value in (k, k, k, 0)
    )
    main = struct.pack("<4I5I16x", 100_000, 0, 0, 0, len(frames), 0, 1, 0, width) + b""
    stream = struct.pack("<4s4sIHHIIIIIIII8x", b"vids", codec, 0, 0, 0, 0, 1, 10, 0, len(frames), 0, 0, 0)
    streams = chunk(b"LIST", b"strl" + chunk(b"strh", stream) + chunk(b"strf", form))
    header = chunk(b"LIST", b"hdrl" + chunk(b"avih", main) + streams)
    movie = chunk(b"LIST", b"movi" + b"".join(chunk(b"00dc", data) for data in frames))
    return b"RIFF" + struct.pack("<I", 4 + len(header) + len(movie)) + b"AVI " + header + movie


def jpeg(image: Pixels) -> bytes:
    out = io.BytesIO()
    Image.fromarray(image).save(out, "JPEG", quality=95)
    return out.getvalue()


def fan_picture(range_m: float, bearing_deg: float, width: int = 128, height: int = 144) -> Pixels:
    """A bright disc of 0.3 m radius at one place of FAN's fan."""
    y, x = np.mgrid[0:height, 0:width]
    across, ahead = (x - 64.0) / 25.0, (140.0 - y) / 25.0
    angle = np.radians(bearing_deg)
    disc = np.hypot(across - range_m * np.sin(angle), ahead - range_m * np.cos(angle)) < 0.3
    return np.where(disc, 220, 30).astype(np.uint8)


def brightest(frame: AnyArray) -> tuple[float, float]:
    """Range, m, and bearing, degrees, of the middle of what is bright in FAN's polar image."""
    beams, samples = np.nonzero(np.asarray(frame, np.float64) > 125)
    return 1.0 + (float(samples.mean()) + 0.5) * 0.05, -15.0 + float(beams.mean()) + 0.5


@pytest.mark.parametrize(("codec", "bits"), [(b"MJPG", 24), (bytes(4), 8)])
def test_an_object_is_where_it_was_drawn(tmp_path: Path, codec: bytes, bits: int) -> None:
    pictures = [fan_picture(3.0, -5.0), fan_picture(4.2, 8.0)]
    frames = [jpeg(p) if codec == b"MJPG" else p[::-1].tobytes() for p in pictures]
    path = tmp_path / "clip.avi"
    path.write_bytes(clip(codec, bits, 128, 144, frames))
    sequence = open_pings(path, FAN)
    second, first = sequence.pings[1], sequence.pings[0]
    assert brightest(frame_of(first)) == pytest.approx((3.0, -5.0), abs=0.4)
    assert brightest(frame_of(second)) == pytest.approx((4.2, 8.0), abs=0.4)
    assert (second.t_ns, sequence.timed, second.scale) == (100_000_000, True, "db")
    assert (second.range0_m, second.dr_m) == pytest.approx((1.025, 0.05))
    assert np.degrees(second.bearing_rad)[[0, 29]] == pytest.approx([-14.5, 14.5])


def test_a_video_1_clip_goes_on_from_the_frame_before_in_any_order_of_reading(tmp_path: Path) -> None:
    path = tmp_path / "clip.avi"
    fill = [bytes([value, 0x80]) for value in (10, 20)]
    path.write_bytes(clip(b"CRAM", 8, 8, 4, [fill[0] * 2, bytes([1, 0x84]) + fill[1], bytes([1, 0x84]) + fill[0]]))
    frames = AviFrames(path)
    for index in (1, 0, 2, 1):
        assert frames[index][0].tolist() == [10] * 4 + [20 if index == 1 else 10] * 4
    assert not frames.losses


def test_a_frame_that_cannot_be_decoded_shows_the_one_before(tmp_path: Path) -> None:
    path = tmp_path / "clip.avi"
    first, last = jpeg(fan_picture(3.0, -5.0)), jpeg(fan_picture(4.2, 8.0))
    path.write_bytes(clip(b"MJPG", 24, 128, 144, [first, b"nothing like a JPEG image", last]))
    pings = open_pings(path, FAN)
    assert pings.pings[1].data == pings.pings[0].data
    assert brightest(frame_of(pings.pings[2])) == pytest.approx((4.2, 8.0), abs=0.4)
    assert pings.losses == {"corrupt_frames": 1}


def test_an_empty_frame_repeats_the_one_before_and_takes_its_time(tmp_path: Path) -> None:
    path = tmp_path / "clip.avi"
    picture = jpeg(fan_picture(3.0, -5.0))
    path.write_bytes(clip(b"MJPG", 24, 128, 144, [picture, b"", picture]))
    assert [ping.t_ns for ping in open_pings(path, FAN).pings] == [0, 200_000_000]


def test_without_pyav_one_line_tells_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "clip.avi"
    path.write_bytes(clip(b"MJPG", 24, 128, 144, [jpeg(fan_picture(3.0, 0.0))]))
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(PingFileError, match=r"clips need PyAV: pip install 'ods\[clips\]'$"):
        open_pings(path, FAN)


def test_resampling_is_exact_on_a_plane_and_zero_outside() -> None:
    y, x = np.mgrid[0:20, 0:30]
    image = (3 * x + 5 * y).astype(np.uint8)
    got = sample_image(image, np.array([2.0, 2.4, 19.0, 19.1, -0.1]), np.array([3.0, 3.0, 29.0, 5.0, 5.0]))
    assert got.tolist() == [19, 21, 182, 0, 0]


@pytest.mark.parametrize(
    ("edit", "message"),
    [
        (lambda data: data.replace(b"AVI ", b"WAVE"), "not one of the known formats"),
        (lambda data: data.replace(b"MJPG", b"????"), "none that FFmpeg can decode"),
        (lambda data: data.replace(b"00dc", b"01wb"), "no image in it"),
        (lambda data: data.replace(b"strf", b"none"), "no image in it"),
        (lambda data: data[:24], "Invalid data"),
        (lambda data: data.replace(b"movi", b"none"), "no image in it|Invalid data"),
        (lambda _: clip(b"MJPG", 24, 16, 9000, [jpeg(np.zeros((9000, 16), np.uint8))]), "16 x 9000 pixels"),
    ],
)
def test_broken_clips_are_one_line(tmp_path: Path, edit: object, message: str) -> None:
    path = tmp_path / "clip.avi"
    assert callable(edit)
    path.write_bytes(edit(clip(b"MJPG", 24, 128, 144, [jpeg(fan_picture(3.0, 0.0))])))
    with pytest.raises(PingFileError, match=message) as caught:
        open_pings(path, FAN)
    assert "\n" not in str(caught.value)


def test_a_cut_off_clip_keeps_its_whole_frames(tmp_path: Path) -> None:
    path = tmp_path / "clip.avi"
    path.write_bytes(clip(b"MJPG", 24, 128, 144, [jpeg(fan_picture(3.0, 0.0))] * 3)[:-20])
    sequence = open_pings(path, FAN)
    assert len(sequence.pings) == 2
    assert sequence.losses["truncated_frames"] == 1


def test_lists_nested_deeper_than_python_may_call_itself(tmp_path: Path) -> None:
    path = tmp_path / "clip.avi"
    whole = clip(b"MJPG", 24, 128, 144, [jpeg(fan_picture(3.0, 0.0))])
    huge = struct.pack("<I", 2**31)
    path.write_bytes(b"RIFF" + huge + b"AVI " + (b"LIST" + huge + b"deep") * 3000 + whole[12:])
    assert len(open_pings(path, FAN).pings) == 1


@pytest.mark.parametrize("side", [64, 65500])
def test_an_image_of_another_size_counts_as_corrupt(tmp_path: Path, side: int) -> None:
    path = tmp_path / "clip.avi"
    good = jpeg(fan_picture(3.0, -5.0))
    size = struct.pack(">HH", 144, 128)
    assert good.count(size) == 1
    path.write_bytes(clip(b"MJPG", 24, 128, 144, [good, good.replace(size, struct.pack(">HH", side, side))]))
    sequence = open_pings(path, FAN)
    assert sequence.pings[1].data == sequence.pings[0].data
    assert sequence.losses == {"corrupt_frames": 1}


def test_a_fan_beside_the_image_and_no_fan_at_all(tmp_path: Path) -> None:
    path = tmp_path / "clip.avi"
    path.write_bytes(clip(b"MJPG", 24, 16, 16, [jpeg(np.zeros((16, 16), np.uint8))]))
    with pytest.raises(PingFileError, match="outside the image"):
        open_pings(path, FAN)
    with pytest.raises(PingFileError, match="needs its fan geometry"):
        open_pings(path)


def test_command_with_a_geometry_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "clip.avi").write_bytes(clip(b"MJPG", 24, 128, 144, [jpeg(fan_picture(3.0, -5.0))]))
    fan = tmp_path / "fan.toml"
    text = "apex_x_px = 64\napex_y_px = 140\npixels_per_m = 25\nbearing_min_deg = -15\nbearing_max_deg = 15\n"
    fan.write_text(text + "range_min_m = 1\nrange_max_m = 5\n")
    assert cli.main(["detect", str(tmp_path / "clip.avi"), "--fan", str(fan)]) == 0
    reported = re.search(r"strongest: (\S+) m at (\S+) deg", capsys.readouterr().out)
    assert reported
    assert (float(reported[1]), float(reported[2])) == pytest.approx((3.0, -5.0), abs=0.5)
    fan.write_text(text + "range_min_m = 5\nrange_max_m = 1\n")
    assert cli.main(["detect", str(tmp_path / "clip.avi"), "--fan", str(fan)]) == 2
    assert "range_max_m" in capsys.readouterr().err
