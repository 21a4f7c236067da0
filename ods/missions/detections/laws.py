"""The laws by which detections are drawn, and their file: fitted by `ods missions CAMPAIGN.toml --fit`."""

import re
from functools import lru_cache
from hashlib import sha256
from pathlib import Path
from typing import Annotated, NamedTuple

import msgspec
import numpy as np

from ods.base.arrays import Floats
from ods.base.errors import OdsError, reason_of
from ods.base.files.in_file import content_of
from ods.base.files.out_file import written_whole
from ods.messages import Detection, Sector
from ods.missions.detections.sights import WORDS
from ods.missions.settings import Campaign
from ods.pipeline.settings import PipelineSettings
from ods.sim_sonar.sonar.model import SonarModel

NODES = 25
"""Of a distribution's quantiles: at normal scores evenly from -REACH to REACH."""
REACH = 3.0

Row = tuple[float, ...]


class Errors(NamedTuple):
    """An echo beside its body, in units in which laws are smooth: (m,) each, or one."""

    near: Floats
    """Nearest point, over what is seen of the body, m."""
    middle: Floats
    """Range of the circle's middle over that of the body's, in units of its radius."""
    bearing: Floats
    """In beams."""
    radius: Floats
    """Logarithm of its ratio to the object's."""
    sigma_range: Floats
    """so of all that follow, in m or rad."""
    sigma_bearing: Floats
    sigma_radius: Floats
    sigma_near: Floats
    range_extent: Floats
    bearing_extent: Floats
    mean: Floats
    """Of the ratio of mean and peak."""
    snr: Floats
    """dB."""
    onset: Floats
    front: Floats
    """Logit."""


class EchoLaw(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """What echoes of bodies are like: mean and scale by features, the distribution about them, and its memory."""

    mean: list[Row]
    """A row a feature of WORDS, a column each of `Errors`."""
    scale: list[Row]
    """Of the logarithm of the mean size of what is left."""
    quantiles: list[Row]
    """A row each of `Errors`: what is left, over its scale, at NODES."""
    mixing: list[Row]
    """Lower triangle (Cholesky) of the correlation between them, of normal scores."""
    memory: Row
    """Their correlation from ping to ping."""


class ClutterLaw(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Echoes of no body."""

    per_scan: Annotated[float, msgspec.Meta(ge=0.0, le=1000.0)]
    stays: Annotated[float, msgspec.Meta(ge=0.0, le=1.0)]
    """How likely it is received again in the next ping, at the same place."""
    echoes: list[Detection]
    """Some that were received."""
    faint: list[bool]
    """Of each: it was a faint one."""


class Laws(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """FILE.json."""

    sonar: str
    """Fingerprint of the data it was fitted to."""
    pipeline: str
    world: str
    features: list[str]
    lowest: Row
    """Of the features where it was fitted: beyond, the laws say what they say there."""
    highest: Row
    seen: Row
    """Logit of the probability of detection, by features."""
    faint: Row
    """Logit of the probability that an echo is weak."""
    cut: Row
    """Logit of the probability that an echo is cut off."""
    errors: list[str]
    """Names of `Errors`, in whose order the columns of `whole` and `cut_off` stand."""
    whole: EchoLaw
    """Echoes that are not cut off."""
    cut_off: EchoLaw
    clutter: ClutterLaw
    sector: Sector
    processed_ranges_m: list[list[tuple[float, float]]]
    """Ping by ping, again and again."""
    heard_from_db: float | None
    chain_ms: float
    """Median CPU time of the pipeline a ping where it was fitted; no part of any result."""
    pings: int
    """Number of pings it was fitted to."""
    echoes: int
    """Number of echoes of objects it was fitted to."""

    def __post_init__(self) -> None:
        if tuple(self.features) != WORDS or tuple(self.errors) != Errors._fields:
            raise ValueError("features, errors: not those of this version of ODS: fit it again")


def fingerprints(campaign: Campaign, pipeline: PipelineSettings, sonar: SonarModel) -> dict[str, str]:
    """Return what laws depend on: by names of `Laws`."""
    world = campaign.world
    parts = {
        "pipeline": msgspec.json.encode(pipeline, enc_hook=str),
        "world": msgspec.json.encode((world.surface, world.sea_bed, world.image, world.height_m, world.down_m)),
    }
    return {"sonar": sonar_fingerprint(sonar), **{key: sha256(value).hexdigest()[:16] for key, value in parts.items()}}


def sonar_fingerprint(sonar: SonarModel) -> str:
    """Return what no two sonars have in common, whatever their names: the same in each process."""
    parts = [getattr(sonar, name) for name in sonar.__dataclass_fields__]
    return sha256(b"".join(np.asarray(part).tobytes() for part in parts if part is not None)).hexdigest()


def refuse_others(laws: Laws, campaign: Campaign, pipeline: PipelineSettings, sonar: SonarModel) -> None:
    """Raise OdsError where laws are used for something that they were not fitted to."""
    for key, value in fingerprints(campaign, pipeline, sonar).items():
        if getattr(laws, key) != value:
            what = {"sonar": "another sonar", "pipeline": "another pipeline", "world": "a world of other echoes"}[key]
            raise OdsError(f"detections: {campaign.detections} was fitted to {what}: fit it again by --fit")


@lru_cache(maxsize=8)
def load_laws(path: Path) -> Laws:
    """Read a file of laws. Raises OdsError."""
    try:
        return msgspec.json.decode(content_of(path), type=Laws)
    except OSError as error:
        raise OdsError(f"detections: {path}: {reason_of(error)}") from error
    except (msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise OdsError(f"detections: {path}: {error}") from error


def save_laws(laws: Laws, path: Path) -> None:
    """Write a file of laws. Raises OdsError."""
    try:
        with written_whole(path) as part:
            text = msgspec.json.format(msgspec.json.encode(laws), indent=1).decode()
            part.write_text(_rows_in_lines(text) + "\n", encoding="utf-8")
    except OSError as error:
        raise OdsError(f"{path}: {reason_of(error)}") from error


def _rows_in_lines(text: str) -> str:
    """Return JSON with arrays of numbers in one line each."""
    return re.sub(r"\[[^\[\]{}\"]*\]", lambda match: re.sub(r"\s+", " ", match[0]), text)
