"""Requests of planners that wait for the sonar to take a setting. Pure: the caller passes the time.

A later request for the same setting replaces an earlier one, so no more wait than there are settings.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass

from ods.base.clock import NS
from ods.messages import SonarAnswer, SonarRequest
from ods.sonar_link.setting_requests import REQUESTABLE_SETTINGS, RequestState, SettingRequests

Peer = list[bytes]
SendAnswer = Callable[[Peer, SonarAnswer], None]


@dataclass(frozen=True)
class _Waiting:
    peer: Peer
    names: frozenset[str]
    deadline_ns: int


class PlannerRequests:
    """Turns planners' requests into setting requests, and answers each when these have succeeded or failed."""

    def __init__(self, settings: SettingRequests, patience_s: float, send: SendAnswer) -> None:
        """`send` gives an answer to a peer and never waits; `patience_s`: how long a silent sonar is waited for."""
        self._settings = settings
        self._patience_ns = round(patience_s * NS)
        self._send = send
        self._waiting: list[_Waiting] = []

    def take(self, peer: Peer, request: SonarRequest, now_ns: int) -> None:
        """Take one request; one without a setting is answered at once with the sonar's report."""
        wanted = {name: value for name in REQUESTABLE_SETTINGS if (value := getattr(request, name)) is not None}
        for name, value in wanted.items():
            unsupported_reason = (
                self._settings.unsupported_reason(name) if math.isfinite(value) else f"{name}: {value} is not a number"
            )
            if unsupported_reason:
                return self._answer(peer, unsupported_reason)
        if not wanted:
            return self._answer(peer, "" if self._settings.reported else "the sonar has not reported its settings yet")
        for earlier in self._waiting:
            if earlier.names & wanted.keys():
                self._answer(earlier.peer, "replaced by a later request")
        self._waiting = [earlier for earlier in self._waiting if not earlier.names & wanted.keys()]
        for name, value in wanted.items():
            self._settings.request(name, value)
        self._waiting.append(_Waiting(peer, frozenset(wanted), now_ns + self._patience_ns))
        return None

    def answer(self, now_ns: int) -> None:
        """Answer those that are done, and those that have waited too long; drop failed requests."""
        still = []
        for waiting in self._waiting:
            states = {name: self._settings.state(name) for name in sorted(waiting.names)}
            failed = [name for name, state in states.items() if state is RequestState.FAILED]
            if failed:
                self._answer(waiting.peer, "; ".join(map(self._settings.failure, failed)))
            elif all(state is RequestState.ACCEPTED for state in states.values()):
                self._answer(waiting.peer, "")
            elif now_ns >= waiting.deadline_ns:
                reason = (
                    f"the sonar has been silent for {self._patience_ns / NS:g} s; the request is sent when it is back"
                )
                self._answer(waiting.peer, reason)
            else:
                still.append(waiting)
        self._waiting = still
        self._settings.drop_failed_requests()

    def _answer(self, peer: Peer, reason: str) -> None:
        reported = self._settings.reported
        values = {name: _finite(getattr(reported, name)) for name in REQUESTABLE_SETTINGS} if reported else {}
        self._send(peer, SonarAnswer(ok=not reason, reason=reason, **values))


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
