"""Reception of a Sonar 3D-15: the [sonar.sonar3d15] table."""

from ods.base.settings import Settings
from ods.runtime.port.address import refuse_no_ip_address


class Sonar3d15Settings(Settings, frozen=True):
    """Nothing is sent."""

    interface: str = ""
    """This computer's IPv4 address in the sonar's network, for multicast; "": by the routing table, often the wrong one
    of several."""
    sender: str = ""
    """IP address of the sonar; "": any, if there is only one."""

    def __post_init__(self) -> None:
        refuse_no_ip_address("interface", self.interface)
        refuse_no_ip_address("sender", self.sender)
        if ":" in self.interface:
            raise ValueError(f"interface: {self.interface}: multicast groups need IPv4")
