"""What has to be done before a chain is changed, so that the change is of nothing else."""

from ods.workbench.model import actions as do
from ods.workbench.model.apply import apply
from ods.workbench.model.chain.numbers import follows
from ods.workbench.model.paths import PathError
from ods.workbench.model.state import State


def with_numbers_first(state: State, action: do.Action, dr_m: float) -> tuple[do.Action, ...]:
    """Return an action, and before it that the chain's numbers are written out, if they followed no more behind it.

    A chain with one number of its own, or with other stages, is taken as it is written: all of its numbers, and how
    many samples are averaged, would change with the one that is set.
    """
    if not follows(state.tuning) or _goes_on(state, action):
        return (action,)
    first = do.WriteNumbers(dr_m)
    try:
        apply(apply(state, first), action)
    except PathError:  # it is refused, whatever was written
        return (action,)
    return first, action


def _goes_on(state: State, action: do.Action) -> bool:
    try:
        return follows(apply(state, action).tuning)
    except PathError:  # such as of a smallest object and a number beside it
        return False
