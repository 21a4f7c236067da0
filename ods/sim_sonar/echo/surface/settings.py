"""Settings of a surface in config/scenes/*.toml."""

from typing import Annotated

import msgspec

from ods.base.settings import NonNegative, Settings


class Surface(Settings, frozen=True, kw_only=True):
    """How a surface reflects (eq. 3)."""

    cd: NonNegative = 0.3
    """Diffuse share Cd."""
    cs: NonNegative = 0.3
    """Specular share Cs."""
    sigma_deg: Annotated[float, msgspec.Meta(gt=0.0, le=90.0)] = 15.0
    """Of the facets' slope."""
