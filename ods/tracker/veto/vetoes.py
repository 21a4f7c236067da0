"""The vetoes in force, and the obstacles of a list that they cover.

A veto by id names the obstacle where and as large as it is then: it ends for good when the obstacle's circle leaves the
one that it had, and `AROUND_M` around. One of a region names what rests whole inside.
"""

from collections.abc import Callable, Sequence

import msgspec

from ods.base.clock import NS
from ods.messages import LARGEST_REGION_M, Obstacle, Veto, VetoRegion, VetoRequest
from ods.tracker.settings import REST
from ods.tracker.veto.region import lies_in

AROUND_M = 2.0
"""Distance, m, by which an obstacle vetoed by id may move or grow: what its position and size change by from ping to
ping."""
MOST = 32


class VetoState(msgspec.Struct, frozen=True):
    """State that a killed tracker leaves to the next one."""

    next_number: int = 0
    vetoes: list[Veto] = []


class RefusedError(Exception):
    """A request cannot be carried out; the text says why in plain words."""


class Vetoes:
    """Those of one mission."""

    def __init__(self, state: VetoState | None = None) -> None:
        """Begin without any, or with those of a former tracker."""
        state = VetoState() if state is None else state
        self._next_number = state.next_number
        self._held = list(state.vetoes)
        self.ended: list[str] = []
        """Vetoes that ended by themselves since this was last emptied, a text each."""

    def state(self) -> VetoState:
        """Return the state for the next tracker."""
        return VetoState(self._next_number, list(self._held))

    def held(self, now_ns: int, utc_of: Callable[[int], int]) -> list[Veto]:
        """Return those that hold; `utc_of`: UTC of an instant, ns, as it is known now."""
        self._expire(now_ns)
        return [msgspec.structs.replace(veto, until_utc_ns=utc_of(veto.until_ns)) for veto in self._held]

    def ignore(self, request: VetoRequest, author: str, present: Sequence[Obstacle], now_ns: int) -> None:
        """Hold a veto; `present`: the obstacles of now. Raises RefusedError."""
        if len(self._held) >= MOST:
            raise RefusedError(f"{MOST} vetoes are in force already: restore one first")
        region = request.region
        if request.id is not None:
            region = _around(obstacle_of(request.id, present))
            self._held = [veto for veto in self._held if veto.id != request.id]
        if region is None or request.for_s is None:
            raise RefusedError("needs an id or a region, and a time")
        until_ns = now_ns + round(request.for_s * NS)
        self._held.append(
            Veto(
                number=self._next_number,
                author=author,
                reason=request.reason,
                until_ns=until_ns,
                until_utc_ns=0,
                region=region,
                id=request.id,
            )
        )
        self._next_number += 1

    def restore(self, request: VetoRequest) -> None:
        """End the veto that a request names. Raises RefusedError."""
        kept = [
            veto
            for veto in self._held
            if (request.id is None or veto.id != request.id) and veto.number != request.number
        ]
        if len(kept) == len(self._held):
            named = f"number {request.number}" if request.id is None else f"obstacle {request.id}"
            raise RefusedError(f"no veto of {named}: restore the veto of a region by its number")
        self._held = kept

    def drop(self, gone: int, why: str) -> None:
        """End the veto of an obstacle that is gone."""
        self._end(why, lambda veto: veto.id == gone)

    def end_all(self, why: str) -> None:
        """End all, as places mean something else now."""
        self._end(why, lambda _: True)

    def marked(self, obstacles: list[Obstacle], now_ns: int) -> list[Obstacle]:
        """Return the obstacles of a list, those with `ignored_by` that a veto names."""
        self._expire(now_ns)
        by_id = {veto.id: veto for veto in self._held if veto.id is not None}
        for each in obstacles if by_id else ():
            veto = by_id.get(each.id)
            if veto is None:
                continue
            if each.state == "terminated":
                self.drop(each.id, "the obstacle ended")
            elif not lies_in(each, veto.region):
                self.drop(each.id, "the obstacle has left the vetoed area")
        return [_marked(each, self._held) for each in obstacles] if self._held else obstacles

    def _expire(self, now_ns: int) -> None:
        self._end("it expired", lambda veto: veto.until_ns <= now_ns)

    def _end(self, why: str, does: Callable[[Veto], bool]) -> None:
        over = [veto for veto in self._held if does(veto)]
        if over:
            self._held = [veto for veto in self._held if veto not in over]
            self.ended += [f"veto {veto.number} of {_meant(veto)}, by {veto.author}, has ended: {why}" for veto in over]


def obstacle_of(wanted: int, present: Sequence[Obstacle]) -> Obstacle:
    """Return the obstacle with an id. Raises RefusedError."""
    for each in present:
        if each.id == wanted and each.state != "terminated":
            return each
    raise RefusedError(f"no obstacle {wanted} in the list")


def _around(obstacle: Obstacle) -> VetoRegion:
    """Raises RefusedError."""
    north, east, _ = obstacle.position_ned
    radius_m = obstacle.radius_m + AROUND_M
    if radius_m > LARGEST_REGION_M:
        raise RefusedError(f"obstacle {obstacle.id} is too large: {obstacle.radius_m:.0f} m")
    return VetoRegion(centre_ne=(north, east), radius_m=radius_m)


def _marked(obstacle: Obstacle, vetoes: Sequence[Veto]) -> Obstacle:
    if obstacle.state == "terminated":
        return obstacle
    for veto in vetoes:
        named = 1.0 - obstacle.moving >= REST if veto.id is None else veto.id == obstacle.id
        if named and lies_in(obstacle, veto.region):
            return msgspec.structs.replace(obstacle, ignored_by=veto.number)
    return obstacle


def _meant(veto: Veto) -> str:
    return "a region" if veto.id is None else f"obstacle {veto.id}"
