"""Intermediate images of a ping after each stage, for the workbench. Not used on board."""

from collections.abc import Callable
from typing import NamedTuple

from ods.base.arrays import Image
from ods.pipeline.image.fan import Fan

RECORDED = "recorded"


class StageImage(NamedTuple):
    """An image on its way through the chain."""

    label: str
    """Name of the stage that made it, or RECORDED."""
    image: Image
    """(beams, samples) amplitude; a copy."""
    fan: Fan
    """Where its cells lie; the same object for all images of one plane or ring."""
    levels: tuple[float, float] | None = None
    """Low and high level of the detector, on its last image: what it compared with them."""


Watch = Callable[[StageImage], None]
