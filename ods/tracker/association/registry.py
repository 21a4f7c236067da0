"""The library of associations: how the echoes of an image are given to objects, chosen by name.

`ASSOCIATIONS` maps the name in the configuration to the function.
"""

from typing import Protocol

from ods.base.arrays import Floats, Mask
from ods.tracker.association.gnn import Candidates, Pairing, nearest
from ods.tracker.association.jpda import probabilistic
from ods.tracker.measurement.model import Sight
from ods.tracker.measurement.scan import Echoes
from ods.tracker.observer.belief import Estimate


class Association(Protocol):
    """Gives the m echoes of an image to n objects."""

    def __call__(
        self,
        found: Candidates,
        worth: Floats,
        first: Mask,
        echoes: Echoes,
        sight: Sight,
        estimate: Estimate,
    ) -> Pairing:
        """Decide between the pairs `found` by their (p,) `worth`.

        `first`: (n,) objects that choose before the others; `sight`, `estimate`: of n objects, as predicted.
        """


ASSOCIATIONS: dict[str, Association] = {"nearest": nearest, "probabilistic": probabilistic}


def association_of(name: str) -> Association:
    """Return the association of that name. Raises ValueError when there is none."""
    if name not in ASSOCIATIONS:
        there = ", ".join(sorted(ASSOCIATIONS))
        raise ValueError(f"tracker.association: no association {name!r}; there are: {there}")
    return ASSOCIATIONS[name]
