"""Frames of .avi clips as grey images, decoded by FFmpeg through PyAV (the extra `clips`)."""

from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from ods.base.arrays import Bytes
from ods.base.clock import NS
from ods.sonar_link.files.ping_sequence import PingFileError

if TYPE_CHECKING:
    from av.container import InputContainer
    from av.packet import Packet
    from av.video.frame import VideoFrame
    from av.video.stream import VideoStream

MAX_SIDE = 8192
MAX_PIXELS = MAX_SIDE * MAX_SIDE
"""Of one image, where it says another size than the file."""
END = 2**63
"""Behind every frame."""


class AviFrames:
    """The frames of a clip, (rows, columns) uint8 brightness, row 0 the top one."""

    def __init__(self, path: Path) -> None:
        """Find the frames; they are decoded when asked for. Raises PingFileError."""
        self.losses: Counter[str] = Counter()
        """`truncated_frames`, and `corrupt_frames` as they are met."""
        self._path = path
        with _open(path) as container:
            video = container.streams.video[0]
            self.shape = video.height, video.width
            """(rows, columns)."""
            self.period_ns = round(NS / video.average_rate) if video.average_rate else 0
            """From one frame to the next, ns; 0 when the file does not report."""
            self.places = self._find(container.demux(video))
            """Number of each frame in time, rising: an empty one, which repeats the one before, has none."""
        if not all(1 <= side <= MAX_SIDE for side in self.shape):
            raise PingFileError(f"{path}: images of {self.shape[1]} x {self.shape[0]} pixels")
        if not self.places:
            raise PingFileError(f"{path}: no image in it")
        self._corrupt: set[int] = set()
        self._pass = _Pass(path, self.shape)
        self._shown = -1

    def __len__(self) -> int:
        return len(self.places)

    def __getitem__(self, index: int) -> Bytes:
        """Return one frame. One that cannot be decoded is counted in `losses` and shows what the one before showed."""
        if index < self._shown:
            self._pass, self._shown = _Pass(self._path, self.shape), -1
        for place in self.places[self._shown + 1 : index + 1]:
            if not self._pass.reach(place):
                self._corrupt.add(place)
                self.losses["corrupt_frames"] = len(self._corrupt)
        self._shown = index
        return self._pass.image

    def _find(self, packets: "Iterator[Packet[VideoStream]]") -> list[int]:
        places = set()
        for packet in packets:
            if packet.is_corrupt:
                self.losses["truncated_frames"] += 1
            elif packet.size and packet.pts is not None:
                places.add(packet.pts)
        return sorted(places)


class _Pass:
    """One pass over a clip; to go back is another one, as FFmpeg reports a palette only once."""

    def __init__(self, path: Path, shape: tuple[int, int]) -> None:
        self.image: Bytes = np.zeros(shape, np.uint8)
        """The newest image up to the place that was reached."""
        self._images = _images(path, shape)
        self._ahead = -1, self.image

    def reach(self, place: int) -> bool:
        """Go on to a place, later than those before; return whether there is an image."""
        while self._ahead[0] < place:
            self._ahead = next(self._images, (END, self.image))
        if self._ahead[0] > place:
            return False
        self.image = self._ahead[1]
        return True


def _images(path: Path, shape: tuple[int, int]) -> Iterator[tuple[int, Bytes]]:
    """Yield place and brightness of each frame that can be decoded and has the clip's size."""
    from av import FFmpegError

    with _open(path) as container:
        video = container.streams.video[0]
        video.codec_context.options = {"max_pixels": str(MAX_PIXELS)}
        for packet in container.demux(video):
            try:
                frames = packet.decode()
            except FFmpegError:
                continue
            for frame in frames:
                if frame.pts is not None and (frame.height, frame.width) == shape:
                    yield frame.pts, _brightness(frame)


def _open(path: Path) -> "InputContainer":
    try:
        import av
    except ImportError:
        raise PingFileError(f"{path}: clips need PyAV: pip install 'ods[clips]'") from None
    try:
        container = av.open(f"file:{path}", format="avi")
    except (OSError, av.FFmpegError) as error:
        raise PingFileError(f"{path}: {error.strerror}") from error
    video = container.streams.video
    if not video or video[0].codec_context is None:
        raise PingFileError(f"{path}: no image in it, or none that FFmpeg can decode")
    return container


def _brightness(frame: "VideoFrame") -> Bytes:
    """Return the (rows, columns) mean of red, green and blue."""
    colours = frame.to_ndarray(format="rgb24")
    mean: Bytes = (colours.sum(axis=2, dtype=np.uint16) // 3).astype(np.uint8)
    return mean
