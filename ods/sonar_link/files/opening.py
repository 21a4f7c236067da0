"""Opens any recording of pings: the decoder is chosen by what the file holds, its suffix decides only where that is
ambiguous.

Those of the user's own, as far as their plug-ins are loaded, go before those that come with ODS.
"""

from collections.abc import Sequence
from itertools import chain
from pathlib import Path

from ods.base.errors import OdsError
from ods.base.files.in_file import opened
from ods.base.plugins import reason
from ods.sonar_link.files.aris import ArisDecoder
from ods.sonar_link.files.decoder import PLUGGED_IN, START_BYTES, Decoder
from ods.sonar_link.files.fan_image import FanClipDecoder, FanGeometry
from ods.sonar_link.files.npz import NpzDecoder
from ods.sonar_link.files.ping_sequence import PingFileError, PingSequence
from ods.sonar_link.files.s7k.decoder import S7kDecoder
from ods.sonar_link.files.streams.norbit import NorbitDecoder
from ods.sonar_link.files.streams.oculus import OculusDecoder
from ods.sonar_link.files.streams.sonar3d15 import Sonar3d15Decoder
from ods.sonar_link.files.viewpoint.database import OculusDatabaseDecoder
from ods.sonar_link.files.viewpoint.log import OculusLogDecoder

__all__ = ["DECODERS", "PingFileError", "PingSequence", "open_pings"]

DECODERS: tuple[Decoder, ...] = (
    NpzDecoder(),
    S7kDecoder(),
    ArisDecoder(),
    OculusDecoder(),
    OculusLogDecoder(),
    OculusDatabaseDecoder(),
    NorbitDecoder(),
    Sonar3d15Decoder(),
    FanClipDecoder(),
)
"""Every format that comes with ODS, in any order."""


def open_pings(path: Path, fan: FanGeometry | None = None) -> PingSequence:
    """Open a recording of one of DECODERS; `fan`: the geometry of the fan images of an .avi clip.

    Raises PingFileError, whose text is one line.
    """
    own = [make() for make in PLUGGED_IN.values()]
    decoder = _decoder_of(path, [*own, *([FanClipDecoder(fan)] if fan else []), *DECODERS])
    try:
        return decoder.read(path)
    except OdsError:
        raise
    except Exception as error:
        if decoder not in own:
            raise
        raise PingFileError(f"{path}: {decoder.name}: {reason(error)}") from error


def _decoder_of(path: Path, decoders: Sequence[Decoder]) -> Decoder:
    start = _start_of(path)
    by_content = [decoder for decoder in decoders if decoder.recognizes(start)]
    by_content.sort(key=_place)  # where s7k has its sync word, others have numbers, such as that of their frames
    by_suffix = [decoder for decoder in decoders if decoder.suffix == path.suffix.lower()]
    chosen = next(chain(by_content, by_suffix), None)
    if chosen is None:
        names = ", ".join(dict.fromkeys(decoder.name for decoder in decoders))
        raise PingFileError(f"{path}: not one of the known formats: {names}, .mcap")
    return chosen


def _place(decoder: Decoder) -> int:
    return decoder.signature[0][0]


def _start_of(path: Path) -> bytes:
    try:
        with opened(path) as file:
            start = file.read(START_BYTES)
    except OSError as error:
        raise PingFileError(f"{path}: {error.strerror}") from error
    if not start:
        raise PingFileError(f"{path}: the file is empty")
    return start
