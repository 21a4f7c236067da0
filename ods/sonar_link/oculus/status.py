"""Status broadcasts of the Oculus sonars on the network, and this sonar's among them. Pure."""

from collections import Counter
from ipaddress import IPv4Address

from ods.base.clock import NS
from ods.sonar_link.oculus.messages import SonarStatus, decode_status

STALE_S = 5.0
"""A status older than this shows nothing; a sonar sends one about every second."""
MODELS = {
    1032: "M750d", 1041: "M370s", 1042: "M1200d", 1134: "M750d Fusion", 1135: "M750d Artemis", 1209: "M373s",
    1217: "MD370s Impulse", 1218: "M373s Deep", 1219: "MD1200d Impulse", 1220: "N1200s", 1221: "N1200s Deep",
    1228: "M1200d Artemis", 1229: "M370s Artemis", 1244: "MD750d Impulse", 1433: "MD370s", 1434: "MD750d",
    1435: "MD1200d", 1921: "MD750d Burton", 2086: "MD1200d Burton", 2203: "M3000d", 2294: "MD370s Burton",
    2418: "MT370s", 2419: "MT750d", 2420: "MT1200d", 2599: "MT3000d", 2658: "MD3000d Impulse", 2659: "MD3000d Burton",
    4713: "C550d",
}  # fmt: skip
"""By part number."""
RUNNING_FROM = 2
"""Lower numbers in the first three bits of the state: the sonar has halted in its boot loader."""
HALTS = ("its magnetic switch", "a boot loader", "a flash error", "JTAG", "a firmware error", "an incompatibility",
         "a brownout")  # fmt: skip
"""Why it has halted, by the next three bits."""
HOT, TOO_HOT, TRANSMITTER_FAILED = 1 << 14, 1 << 15, 1 << 16
NO_CLIENT = IPv4Address(0)


class StatusBoard:
    """The newest status of the sonar at `address`, and of others. Counters: statuses, other_statuses, bad_status."""

    def __init__(self, address: str, counters: "Counter[str]") -> None:
        self.counters = counters
        self._address = address
        self.newest_ns = 0
        """When a status of any sonar was received last."""
        self._own: tuple[int, SonarStatus] | None = None
        self._other: tuple[int, SonarStatus] | None = None

    def receive(self, datagram: bytes, now_ns: int) -> None:
        """Take what came to the status port."""
        try:
            status = decode_status(datagram)
        except ValueError:
            self.counters["bad_status"] += 1
            return
        self.newest_ns = now_ns
        if str(status.address) == self._address:
            self.counters["statuses"] += 1
            self._own = now_ns, status
        else:
            self.counters["other_statuses"] += 1
            self._other = now_ns, status

    def own(self, now_ns: int) -> SonarStatus | None:
        """Return the sonar's status, None when none is fresh."""
        return _fresh(self._own, now_ns)

    def other(self, now_ns: int) -> SonarStatus | None:
        """Return the status of another sonar that was received last, None when none is fresh."""
        return _fresh(self._other, now_ns)

    def problems(self, now_ns: int) -> list[str]:
        """Return what the sonar says is wrong with it."""
        status = self.own(now_ns)
        return troubles(status) if status else []

    def why_unreachable(self, now_ns: int) -> str:
        """Return what the status messages say of a sonar that cannot be connected to."""
        own, other = self.own(now_ns), self.other(now_ns)
        if own and own.client != NO_CLIENT:
            return f"it reports that {own.client} has its connection"
        if own:
            return "its status is received, so it is on: is this machine in its network?"
        if other:
            return f"a sonar at {other.address} is received ({model_of(other)}): is sonar.port correct?"
        return "no status of any sonar is received: is it on, and is the cable connected?"


def model_of(status: SonarStatus) -> str:
    """Return the model's name, or the part number of one that is not known."""
    return MODELS.get(status.part_number, f"part {status.part_number}")


def troubles(status: SonarStatus) -> list[str]:
    """Return what a status complains of."""
    said = []
    if status.state & 0b111 < RUNNING_FROM:
        reason = status.state >> 3 & 0b111
        said.append(f"the sonar has halted: {HALTS[reason] if reason < len(HALTS) else 'of unknown reason'}")
    if status.state & TOO_HOT:
        said.append("the sonar is too hot and does not ping: is it in the water?")
    elif status.state & HOT:
        said.append("the sonar is hot: is it in the water?")
    if status.state & TRANSMITTER_FAILED:
        said.append("the sonar's transmitter has failed")
    return said


def _fresh(received: tuple[int, SonarStatus] | None, now_ns: int) -> SonarStatus | None:
    return received[1] if received and now_ns - received[0] <= STALE_S * NS else None
