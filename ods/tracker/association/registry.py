"""The library of associations: how the echoes of an image are given to objects, chosen by name.

`ASSOCIATIONS` maps the name in the configuration to the function; a plug-in adds to it:

    @association("greedy")
    def greedy(question: Question) -> Assignment:
        ...
"""

from collections.abc import Callable
from functools import wraps
from typing import Protocol

from ods.base.choices import none_of
from ods.base.plugins import PluginError, add
from ods.tracker.association.assignment import Assignment, Question
from ods.tracker.association.gnn import nearest
from ods.tracker.association.jpda import probabilistic
from ods.tracker.settings import ASSOCIATION_NAMES


class Association(Protocol):
    """Gives the m echoes of an image to n objects."""

    def __call__(self, question: Question) -> Assignment:
        """Decide between the hypotheses by their scores."""


ASSOCIATIONS: dict[str, Association] = {"nearest": nearest, "probabilistic": probabilistic}


def association(name: str) -> Callable[[Association], Association]:
    """Register the decorated function. Raises PluginError when the name is taken."""

    def register(decide: Association) -> Association:
        add(ASSOCIATIONS, "association", name, decide)
        ASSOCIATION_NAMES[name] = None
        return decide

    return register


def association_of(name: str) -> Association:
    """Return the association of that name. Raises PluginError for one that no plug-in has registered."""
    if name not in ASSOCIATIONS:
        raise PluginError(f"tracker.association: {none_of(name, ASSOCIATIONS)}")
    decide = ASSOCIATIONS[name]
    if decide in (nearest, probabilistic):
        return decide

    @wraps(decide)
    def plain(question: Question) -> Assignment:
        return decide(question).plain()

    return plain
