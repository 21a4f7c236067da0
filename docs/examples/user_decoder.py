"""A decoder of your own. Sketch recordings: `SKETCH01`, pings, beams, samples (uint32), then the samples (uint8)."""

import struct
from pathlib import Path

import numpy as np

from ods.messages import Ping
from ods.sonar_link.files.decoder import Decoder, decoder
from ods.sonar_link.files.mapped_file import memory_map
from ods.sonar_link.files.ping_sequence import LazyPings, PingFileError, PingSequence, recorded_ping
from ods.sonar_link.ping_builder import Geometry, make_beam_table

_HEAD = struct.Struct("<8sIII")


@decoder
class SketchDecoder(Decoder):
    """Reads .sketch files. Losses: truncated_ping."""

    name = "Sketch .sketch"
    signature = ((0, b"SKETCH01"),)
    suffix = ".sketch"

    def read(self, path: Path) -> PingSequence:
        """Open a recording. Raises PingFileError."""
        data = memory_map(path)
        if len(data) < _HEAD.size:
            raise PingFileError(f"{path}: ends within its header")
        _, count, beams, samples = _HEAD.unpack_from(data)
        size = beams * samples
        whole = min(count, (len(data) - _HEAD.size) // size) if size else 0

        def make(index: int) -> Ping:
            frame = np.frombuffer(data, np.uint8, size, _HEAD.size + index * size).reshape(beams, samples)
            return recorded_ping(frame, geometry, index)

        try:
            table = make_beam_table(np.radians(np.linspace(-45.0, 45.0, beams)), np.zeros(beams))
            geometry = Geometry(table, range0_m=0.0, dr_m=0.05, sound_speed=1500.0)
            recording = PingSequence(LazyPings(whole, make), timed=False)
            if whole:
                make(0)  # a frame that is no image is a bad file now, not in the middle of the work
        except ValueError as error:
            raise PingFileError(f"{path}: {error}") from None
        recording.losses["truncated_ping"] += count - whole
        return recording
