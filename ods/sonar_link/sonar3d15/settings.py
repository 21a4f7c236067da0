"""Reception of a Sonar 3D-15: the [sonar.sonar3d15] table."""

import ipaddress

from ods.base.settings import Settings


class Sonar3d15Settings(Settings, frozen=True):
    """Nothing is sent."""

    interface: str = ""
    """This computer's IPv4 address in the sonar's network, for multicast; "": by the routing table, often the wrong one
    of several."""
    sender: str = ""
    """IP address of the sonar; "": any, if there is only one."""

    def __post_init__(self) -> None:
        for name in ("interface", "sender"):
            try:
                address = ipaddress.ip_address(getattr(self, name) or "0.0.0.0")
            except ValueError:
                raise ValueError(f"{name}: {getattr(self, name)}: not an IP address, such as 192.168.194.90") from None
            if name == "interface" and address.version == 6:
                raise ValueError(f"{name}: {address}: multicast groups need IPv4")
