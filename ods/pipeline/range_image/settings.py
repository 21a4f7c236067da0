"""Settings of range images: `[pipeline.range_image]`."""

from typing import Annotated

import msgspec

from ods.base.settings import NonNegative, PositiveInt, Settings, slider


class RangeImageSettings(Settings, frozen=True):
    """3-D sonars, which do not use the stages."""

    least_pixels: Annotated[PositiveInt, slider(1, 50)] = 6
    """Objects of fewer pixels are noise."""
    noise_m: Annotated[NonNegative, slider(0.0, 1.0, step=0.01, unit="m")] = 0.1
    """Neighbouring pixels are one object if their ranges differ by no more, beside what a surface 10 degrees off the
    line of sight explains."""
    largest_m: Annotated[float, msgspec.Meta(ge=0.1, le=100.0), slider(0.2, 10.0, step=0.1, unit="m")] = 1.0
    """Largest radius: larger objects, such as walls, are cut into pieces in cells fixed in the world."""
    bottom_m: Annotated[NonNegative, slider(0.0, 3.0, step=0.05, unit="m")] = 0.3
    """Points lower over an even bottom are no object; 0: no bottom is sought."""
