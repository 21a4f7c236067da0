"""Validity of the obstacle list: the reasons why a planner must not rely on it, as text."""

from collections.abc import Callable, Iterable

from ods.base.clock import NS
from ods.base.computer.overload import OVERLOADED, STARVED
from ods.messages import Health
from ods.runtime import bus
from ods.runtime.ping_pace import PingPace

LIST_STALE_S = bus.TOPICS["obstacles"].stale_s
POSE_STALE_S = bus.TOPICS["pose"].stale_s
BLIND_S = 0.5
"""Time for which most of the image may be unobserved, s: a drop-out, a ping or two."""
MOST = 0.5
"""Share of the image."""
SETTLE_S = 1.0
"""From the first ping until every object in view can have been confirmed, if pings do not come seldom."""
TURNS = 4.0
"""Sweeps of a mechanically scanned sonar until an object can have been confirmed."""
NO_SIGN = "no sign of life"
NO_POSE = "no pose for "
NAV_SAYS = f"nav: {NO_POSE}"
AWAY_S = 3.0
"""Time without coverage (no ping, no pose, most of the image not observed), s: then other objects may be in view."""


class InputMonitor:
    """When each was received last. All times are CLOCK_MONOTONIC ns."""

    def __init__(
        self,
        started_ns: int,
        processes: Iterable[str],
        why_ended: Callable[[str], str],
        overload: Callable[[], str] = str,
    ) -> None:
        """`why_ended`: what a process that is gone said last, "" for nothing.

        overload: says that the computer is overloaded, "" while it is not.
        """
        self._why_ended = why_ended
        self._overload = overload
        self._started_ns = started_ns
        self.first_ping_ns: int | None = None
        """Transmission of the first ping, that of the tracker that this one goes on for, if it does, or of the first
        after coverage was lost; None before it."""
        self._begun = "the tracker has just started"
        """What was before that ping."""
        self.looked_ns: int | None = None
        """Transmission of the newest ping that objects could be tracked by, here or by whom this one goes on for."""
        self._ping_ns: int | None = None
        self._pace = PingPace()
        self._turn_s = 0.0
        self._seen_ns: int | None = None
        self._unseen_why = ""
        self._pose_ns: int | None = None
        self._health: dict[str, Health | None] = dict.fromkeys(processes)

    def ping(self, t_ns: int, turn_s: float = 0.0) -> None:
        """Detections of the ping transmitted at `t_ns` came; `turn_s`: see `Detections`."""
        self._turn_s = turn_s
        self.first_ping_ns = t_ns if self.first_ping_ns is None else self.first_ping_ns
        self._ping_ns = t_ns if self._ping_ns is None else max(self._ping_ns, t_ns)
        self._pace.ping(t_ns)

    def observed(self, t_ns: int, unseen_share: float, why: str, *, pose_known: bool = True) -> None:
        """The ping transmitted at `t_ns` did not show a share of the image; `why`, in plain words."""
        self._unseen_why = why
        if not unseen_share > MOST and pose_known:
            self._look(t_ns)
        if not unseen_share > MOST or self._seen_ns is None:  # the first ping may be a drop-out
            self._seen_ns = t_ns if self._seen_ns is None else max(self._seen_ns, t_ns)

    def _look(self, t_ns: int) -> None:
        """Objects can be tracked by the ping transmitted at `t_ns`."""
        looked_ns = self.looked_ns
        if looked_ns is not None and t_ns - looked_ns > AWAY_S * NS:
            self.begin_again(t_ns, "coverage has just returned")
        self.looked_ns = t_ns if looked_ns is None else max(looked_ns, t_ns)

    def begin_again(self, t_ns: int, why: str) -> None:
        """From the ping transmitted at `t_ns` on, objects are confirmed as after a start; why, in plain words."""
        self.first_ping_ns, self._begun = t_ns, why

    def pose(self, t_ns: int) -> None:
        """A pose of the instant `t_ns` came."""
        self._pose_ns = t_ns if self._pose_ns is None else max(self._pose_ns, t_ns)

    def health(self, message: Health) -> None:
        """A health report came, of the process itself or of the supervisor in its place."""
        if message.process in self._health:
            self._health[message.process] = message

    def silent(self, now_ns: int) -> bool:
        """Return whether the last ping is so old that lists must be sent without one."""
        return self._unheard_for(LIST_STALE_S, now_ns)

    def _lost(self, now_ns: int) -> bool:
        """Return whether no ping came for longer than this sonar's pace explains."""
        return self._unheard_for(self._pace.patience_s, now_ns)

    def _unheard_for(self, seconds: float, now_ns: int) -> bool:
        return self._ping_ns is None or now_ns - self._ping_ns > seconds * NS

    def reasons(self, now_ns: int, pose_known: bool) -> list[str]:
        """Return why the list of this moment is not to be relied on; empty when it is.

        `pose_known`: the vehicle's pose was found for the ping behind the list, if there is one.
        """
        found = []
        lost = self._lost(now_ns)
        if lost:
            found.append(_silence("ping", self._ping_ns, now_ns))
        elif self._settling():
            found.append(f"{self._begun}: objects are still being confirmed")
        if not lost and self._blind_s() > BLIND_S:
            found.append(f"{self._unseen_why}, for {self._blind_s():.1f} s")
        if self._pose_ns is None or now_ns - self._pose_ns > POSE_STALE_S * NS:
            found.append(_silence("pose", self._pose_ns, now_ns))
        elif not pose_known:
            found.append("no pose for the time of the ping")
        for process, report in self._health.items():
            found += self._of_process(process, report, now_ns)
        return self._causes(found)

    def _causes(self, found: list[str]) -> list[str]:
        """Return the reasons, that the computer is overloaded before them if it is, and not what others explain.

        That no ping or pose came stays: it is so, whatever the cause; of poses, as the nav process says it. A process
        may notice the overload before this one does.
        """
        if any(reason.startswith(NAV_SAYS) for reason in found):
            found = [reason for reason in found if not reason.startswith(NO_POSE)]
        overload = self._overload() if found else ""
        if not overload and any(OVERLOADED in reason for reason in found):
            overload = STARVED
        if not overload:
            return found
        return [overload, *(reason for reason in found if OVERLOADED not in reason and NO_SIGN not in reason)]

    def _blind_s(self) -> float:
        """Return how long most of the image has been unseen, from ping to ping."""
        return 0.0 if self._seen_ns is None or self._ping_ns is None else (self._ping_ns - self._seen_ns) / NS

    def _settling(self) -> bool:
        if self._ping_ns is None or self.first_ping_ns is None:
            return True
        return self._ping_ns - self.first_ping_ns < max(SETTLE_S, self._pace.patience_s, TURNS * self._turn_s) * NS

    def _of_process(self, process: str, report: Health | None, now_ns: int) -> list[str]:
        newest_ns = self._started_ns if report is None else report.t_ns
        age_s = (now_ns - newest_ns) / NS
        if age_s > bus.HEALTH_STALE_S:
            why = self._why_ended(process)
            return [f"{process}: {NO_SIGN} for {age_s:.1f} s" + (f"; it ended: {why}" if why else "")]
        if report is None:
            return []
        if not report.ready and not report.problems:
            return [f"{process}: not ready"]
        return [f"{process}: {problem}" for problem in report.problems]


def _silence(what: str, newest_ns: int | None, now_ns: int) -> str:
    return f"no {what} yet" if newest_ns is None else f"no {what} for {(now_ns - newest_ns) / NS:.1f} s"
