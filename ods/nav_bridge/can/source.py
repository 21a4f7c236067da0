"""Interface of every navigation source on CAN: frames in, poses and problems out."""

from abc import abstractmethod

from ods.nav_bridge.can.frame import CanId, Frame
from ods.nav_bridge.source import PoseSource


class CanSource(PoseSource[Frame]):
    """One navigation system, by its frames."""

    kind = "CAN"

    @property
    @abstractmethod
    def ids(self) -> frozenset[CanId]:
        """Identifiers that `take` wants."""

    def name_of(self, item: Frame) -> str:
        """Return the frame's identifier."""
        return str(CanId(item.can_id, item.extended))
