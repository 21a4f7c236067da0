"""The requests to a 7k sonar: subscription to records, range, power and gain. Pure: the caller passes the time.

Record 7000, which comes with every ping, says whether a setting took effect; an acknowledgement alone does not.
"""

from ods.sonar_link.s7k import remote_control
from ods.sonar_link.s7k.remote_control import ControlReply, ControlRequest
from ods.sonar_link.setting_requests import Controls, SettingRequest, SettingRequests

COMMAND_OF = {
    "range_m": remote_control.SET_RANGE,
    "power_db": remote_control.SET_POWER,
    "gain_db": remote_control.SET_GAIN,
}
"""By the names of settings."""


class RemoteControl:
    """Requests to one sonar. Counters: control_requests, control_acknowledged, control_refused."""

    def __init__(self, setting_requests: SettingRequests, subscription: tuple[int, ...] = ()) -> None:
        """`subscription`: record types to ask for after each connection, none on a line that sends all."""
        self._setting_requests = setting_requests
        self._counters = setting_requests.counters
        self._records = subscription
        self._subscribe_due = False
        self._subscription_ticket = 0
        self._subscription_error: int | None = None
        self._asked: dict[str, tuple[int, SettingRequest]] = {}
        """Ticket and request that were sent last, by setting."""
        self._ticket = 0

    def connected(self) -> None:
        """Ask for everything again: the line to the sonar is new."""
        self._subscribe_due = bool(self._records)
        self._subscription_error = None
        self._setting_requests.resend()

    def requests(self, now_ns: int) -> list[ControlRequest]:
        """Return the messages to send now."""
        due = []
        if self._subscribe_due:
            self._subscribe_due = False
            self._subscription_ticket = self._next_ticket()
            due.append(remote_control.subscribe(self._subscription_ticket, self._records))
        for request in self._setting_requests.due(now_ns):
            ticket = self._next_ticket()
            self._asked[request.name] = ticket, request
            due.append(remote_control.set_value(COMMAND_OF[request.name], ticket, request.value))
        self._counters["control_requests"] += len(due)
        return due

    def take(self, controls: Controls, now_ns: int) -> None:
        """Take what record 7000 says."""
        self._setting_requests.receive(controls, now_ns)

    def answered(self, reply: ControlReply) -> None:
        """Take what the sonar replied to a request."""
        self._counters["control_acknowledged" if reply.error is None else "control_refused"] += 1
        if reply.error is None:
            return
        if reply.ticket == self._subscription_ticket:
            self._subscription_error = reply.error
        for ticket, request in self._asked.values():
            if ticket == reply.ticket:
                request.refuse(f"error {reply.error}")

    def problems(self) -> list[str]:
        """Return the requests that the sonar refused, as text."""
        said = []
        if self._subscription_error is not None:
            records = ", ".join(map(str, self._records))
            said.append(f"the sonar refused to send records {records} (error {self._subscription_error})")
        return said + self._setting_requests.problems()

    def _next_ticket(self) -> int:
        self._ticket = self._ticket % (2**32 - 1) + 1
        return self._ticket
