"""What the tests ask the booted computer."""

import json
import time
from collections.abc import Callable
from dataclasses import dataclass

from tests.systemd.guest_machine import Guest

PROCESSES = ("nav", "pipeline", "sonar", "tracker")
UNITS = tuple(f"ods@{name}.service" for name in PROCESSES)
PATIENCE_S = 300.0
"""For all that must happen some time: the guest has a share of one CPU, and that is slow."""
PLANNER = ("/opt/ods/bin/python", "-P", "/usr/local/lib/guest/planner.py")


@dataclass(frozen=True)
class Picture:
    """What the planner got: docs/messages/README.md, and the time since power-on."""

    valid: bool
    reasons: list[str]
    positions: list[list[float]]
    up_s: float


@dataclass
class Life:
    """The computer under test."""

    guest: Guest

    def planner(self, user: str = "planner", patience_s: float = PATIENCE_S) -> Picture:
        """Let a path planner of this user wait for a valid list with obstacles."""
        return Picture(*json.loads(self.guest.run(*PLANNER, str(patience_s), user=user, timeout_s=patience_s + 30.0)))

    def property_of(self, unit: str, name: str) -> str:
        """Return a property of a unit."""
        return self.guest.run("systemctl", "show", "--value", f"--property={name}", unit)

    def pid_of(self, unit: str) -> int:
        """Return a unit's process."""
        return int(self.property_of(unit, "MainPID"))

    def states(self) -> dict[str, str]:
        """Return the state of each unit."""
        return dict(zip(UNITS, self.guest.ask("systemctl", "is-active", *UNITS)[1].splitlines(), strict=True))

    def wait_for(self, holds: Callable[[], bool], patience_s: float = PATIENCE_S) -> float:
        """Wait until it holds; return how long it took, s."""
        begun_s = time.monotonic()
        while not holds():
            assert time.monotonic() < begun_s + patience_s, f"{self.states()}: {self.journal()}"
            time.sleep(0.2)
        return time.monotonic() - begun_s

    def wait_for_all_active(self) -> None:
        """Wait until all units are active."""
        self.wait_for(lambda: set(self.states().values()) == {"active"})

    def seconds_until_replaced(self, pids: dict[str, int]) -> float:
        """Wait until units have other processes than these, and are active; return how long it took, s."""

        def replaced() -> bool:
            states = self.states()
            return all(self.pid_of(unit) not in (0, pid) and states[unit] == "active" for unit, pid in pids.items())

        return self.wait_for(replaced)

    def journal(self, user: str = "") -> str:
        """Return what processes and far ends said since power-on, and systemd about them, as a user may read it."""
        units = ("-u", "ods@*", "-u", "test-far-end")
        return self.guest.ask("journalctl", "-b", "-o", "cat", "--no-pager", "-n", "80", *units, user=user)[1]
