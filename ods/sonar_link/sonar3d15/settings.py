"""Where a Sonar 3D-15 is listened to: the [sonar.sonar3d15] table."""

import ipaddress

from ods.base.settings import Settings


class Sonar3d15Settings(Settings, frozen=True):
    """Nothing is sent to the sonar: range, sound speed and mode are set at its own web page."""

    interface: str = ""
    """IPv4 address of the interface of this computer that leads to the sonar, for its multicast group; "": as the
    computer's routing table, which with several interfaces is often another one."""
    sender: str = ""
    """IP address of the sonar; what others send is left out. "": anybody's is taken: there must be one sonar only."""

    def __post_init__(self) -> None:
        for name in ("interface", "sender"):
            try:
                address = ipaddress.ip_address(getattr(self, name) or "0.0.0.0")
            except ValueError:
                raise ValueError(f"{name}: {getattr(self, name)}: not an IP address, such as 192.168.194.90") from None
            if name == "interface" and address.version == 6:
                raise ValueError(f"{name}: {address}: multicast groups need IPv4")
