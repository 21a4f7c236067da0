"""A stage prepared for a geometry: the step that is called for each image.

There are four kinds of image step, by what they read and write; `prepared.filter_chain` calls them.
"""

from collections.abc import Callable, Iterable
from typing import Literal, NamedTuple

from ods.base.arrays import Floats, Image
from ods.messages import Pose
from ods.pipeline.image.gained_image import GainedImage
from ods.pipeline.image.regions import Regions
from ods.pipeline.image.samples.recorded import Recorded
from ods.pose.buffer import PoseEstimate


class PingContext(NamedTuple):
    """When and from where a ping was taken."""

    t_ns: int
    pose: Pose | PoseEstimate | None
    """None where it is not known: the vehicle then counts as standing still."""

    def follows(self, former: "PingContext", longest_gap_s: float) -> bool:
        """Return whether the former ping is neither later nor too old to say anything about this one."""
        return 0 <= self.t_ns - former.t_ns <= longest_gap_s * 1e9


ImageStep = Callable[[Image, Image], None]
"""step(source, out): fills out, (beams, samples) float32, from source of the same shape; they never overlap."""

PingStep = Callable[[Image, Image, PingContext], None]
"""step(source, out, ping): the same, by what earlier pings showed."""

GainedImageStep = Callable[[GainedImage, Image], None]
"""step(image, out): the same; applies the gain itself, while it reads."""

GainStep = Callable[[GainedImage], GainedImage]
"""step(image): changes nothing but the gain. The array of gains may be its own, and is good until the next call."""

DetectStep = Callable[[Image, Recorded], Regions]
"""step(image, recorded): returns the connected regions of an image; `recorded` is what it was made of."""


FIRST_IMAGES = 8
"""Images of speckle of one look that a detector learns from, at least; they come first."""


class PreparedDetector(NamedTuple):
    """A detect stage, prepared."""

    find: DetectStep
    learn: Callable[[Iterable[Iterable[Image]]], None] | None = None
    """Is shown images of speckle, kind by kind, as the stages before leave them, before the first real one."""
    refuses_nan: bool = False
    """`find` raises NotANumberError for an image with NaN; if it does not, the chain looks for them itself."""
    learnt: Floats | None = None
    """All that `learn` fills, where it follows from the stages before and the geometry alone: what another detector of
    that kind has learnt there may be copied into it instead."""


StageKind = Literal["image", "ping", "gained image", "gain", "detect"]
