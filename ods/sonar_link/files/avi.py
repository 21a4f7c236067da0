"""Frames of .avi clips as grey images: Motion JPEG, Microsoft Video 1 and uncompressed 8-bit images.

A RIFF file: the chunk `avih` tells the time between frames, `strf` size, codec and palette of the images, and each
`00dc` or `00db` in the list `movi` is one frame. Source: Microsoft, AVI RIFF File Reference.
"""

import io
import struct
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ods.base.arrays import Bytes
from ods.sonar_link.files import video1
from ods.sonar_link.files.mapped_file import memory_map
from ods.sonar_link.files.ping_sequence import PingFileError

Pixels = Bytes

_LISTS = (b"RIFF", b"LIST")
_FRAMES = (b"00dc", b"00db")
_VIDEO_1 = (b"CRAM", b"MSVC", b"WHAM")
_PLAIN = (b"\0\0\0\0", b"DIB ", b"RGB ")
_JPEG = b"MJPG"
MAX_SIDE = 8192


@dataclass(frozen=True)
class _Format:
    width: int
    height: int
    """Rows; top-down images, whose height is negative in the file, are not written by anybody in 8 bits."""
    codec: bytes
    brightness: Pixels
    """(256,) mean of red, green and blue of each colour number."""


class AviFrames:
    """The frames of a clip, (rows, columns) uint8 brightness, row 0 the top one."""

    def __init__(self, path: Path) -> None:
        """Find the frames; they are decoded when asked for. Raises PingFileError."""
        self.path = path
        self.losses: Counter[str] = Counter()
        self._data = memory_map(path)
        self.period_ns = 0
        self._chunks: list[tuple[int, int]] = []
        found: _Format | None = None
        for name, begin, size in self._walk():
            if name == b"avih" and size >= 4:
                self.period_ns = 1000 * int(struct.unpack_from("<I", self._data, begin)[0])
            elif name == b"strf" and found is None:
                found = self._format(begin, size)
            elif name in _FRAMES and size:
                self._chunks.append((begin, size))
        if found is None or not self._chunks:
            raise PingFileError(f"{path}: no image in it")
        self._form = found
        self._canvas = np.zeros((found.height, found.width), np.uint8)
        self._shown = -1

    def __len__(self) -> int:
        return len(self._chunks)

    @property
    def shape(self) -> tuple[int, int]:
        """Return (rows, columns)."""
        return self._form.height, self._form.width

    def __getitem__(self, index: int) -> Pixels:
        """Return one frame. One that cannot be decoded is counted in `losses` and shows what the one before showed."""
        if index < self._shown:
            self._canvas[:], self._shown = 0, -1
        for place in range(self._shown + 1, index + 1):
            begin, size = self._chunks[place]
            self._shown = place
            try:
                self._decode(self._data[begin : begin + size])
            except (ValueError, OSError):
                self.losses["corrupt_frames"] += 1
        if self._form.codec == _JPEG:
            return self._canvas.copy()
        return self._form.brightness[self._canvas]

    def _decode(self, data: bytes) -> None:
        if self._form.codec in _VIDEO_1:
            video1.decode(data, self._canvas)
        elif self._form.codec == _JPEG:
            self._canvas[:] = _jpeg(data, self.shape)
        else:
            stride = (self._form.width + 3) // 4 * 4  # rows are padded to whole words and stand bottom up
            rows = np.frombuffer(data, np.uint8).reshape(self._form.height, stride)
            self._canvas[:] = rows[::-1, : self._form.width]

    def _walk(self) -> Iterator[tuple[bytes, int, int]]:
        """Yield name, first byte and size of each chunk; what goes on behind the end of the file is cut off."""
        under_way = [(0, len(self._data))]  # where each open list goes on, and its end; lists may nest at any depth
        while under_way:
            place, end = under_way.pop()
            if place + 8 > end:
                continue
            name, size = struct.unpack_from("<4sI", self._data, place)
            begin = place + 8
            under_way.append((begin + size + size % 2, end))
            if name in _LISTS:
                under_way.append((begin + 4, min(begin + size, end)))
            elif begin + size <= end:
                yield name, begin, size
            elif name in _FRAMES:
                self.losses["truncated_frames"] += 1

    def _format(self, begin: int, size: int) -> _Format:
        if size < 40:
            raise PingFileError(f"{self.path}: no description of its images")
        width, height, _, bits, codec = struct.unpack_from("<4xiiHH4s", self._data, begin)
        if not (1 <= width <= MAX_SIDE and 1 <= height <= MAX_SIDE):
            raise PingFileError(f"{self.path}: images of {width} x {height} pixels")
        if not (codec == _JPEG or (bits == 8 and codec in (*_VIDEO_1, *_PLAIN))):
            raise PingFileError(f"{self.path}: images coded as {codec!r} with {bits} bits cannot be read")
        palette = np.frombuffer(self._data[begin + 40 : begin + min(size, 40 + 1024)], np.uint8)
        colours = palette[: palette.size // 4 * 4].reshape(-1, 4)[:, :3]
        brightness = np.zeros(256, np.uint8)
        brightness[: len(colours)] = colours.mean(axis=1)
        return _Format(width, height, codec, brightness)


def _jpeg(data: bytes, shape: tuple[int, int]) -> Pixels:
    """Return the brightness (rows, columns) of a JPEG image. Raises ValueError or OSError."""
    from PIL import Image  # an extra: on board there are no clips

    try:
        picture = Image.open(io.BytesIO(data), formats=("JPEG",))
    except Image.DecompressionBombError as error:
        raise ValueError(str(error)) from error
    if (picture.height, picture.width) != shape:
        raise ValueError("another size of image")
    return np.asarray(picture.convert("L"), np.uint8)
