"""The library of associations: how the echoes of an image are given to objects, chosen by name.

`ASSOCIATIONS` maps the name in the configuration to the function.
"""

from typing import Protocol

from ods.tracker.association.assignment import Assignment, Question
from ods.tracker.association.gnn import nearest
from ods.tracker.association.jpda import probabilistic


class Association(Protocol):
    """Gives the m echoes of an image to n objects."""

    def __call__(self, question: Question) -> Assignment:
        """Decide between the hypotheses by their scores."""


ASSOCIATIONS: dict[str, Association] = {"nearest": nearest, "probabilistic": probabilistic}


def association_of(name: str) -> Association:
    """Return the association of that name; `TrackerSettings` takes no name but one of ASSOCIATIONS."""
    return ASSOCIATIONS[name]
