"""Objects that this node serves beyond the values in its EDS."""

import platform
import struct
from collections import Counter
from typing import Any

from canopen import SdoAbortedError
from canopen.objectdictionary import ODVariable

from ods import __version__
from ods.base.clock import MS
from ods.nav_bridge.can.frame import SYNC
from ods.nav_bridge.canopen.ins_monitor import InsMonitor
from ods.nav_bridge.canopen.node.own_errors import NodeErrors
from ods.nav_bridge.canopen.object_map import ObjectAddress
from ods.nav_bridge.settings import CanopenSettings, NavSettings

ERROR_REGISTER, ERROR_HISTORY, CONSUMER_HEARTBEAT, COUNTER_VALUES = 0x1001, 0x1003, 0x1016, 0x2000
PRODUCES_SYNC = 1 << 30
MASK_32_BIT = 0xFFFFFFFF
MAX_HEARTBEAT_MS = 0xFFFF
NO_DATA, OUT_OF_RANGE = 0x08000024, 0x06090030
"""SDO abort codes."""


class OwnObjects:
    """Answers for `canopen.LocalNode`. A sub-index of object 0x2000 is the counter that the EDS names."""

    def __init__(
        self,
        nav: NavSettings,
        settings: CanopenSettings,
        monitor: InsMonitor,
        errors: NodeErrors,
        counters: Counter[str],
    ) -> None:
        self._monitor, self._errors, self._counters = monitor, errors, counters
        self._ins_node_id = settings.ins_node_id
        self._constants: dict[ObjectAddress, int | str] = {
            (0x1005, 0): SYNC | (PRODUCES_SYNC if settings.sync_period_s else 0),
            (0x1006, 0): round(settings.sync_period_s * 1e6),
            (0x1009, 0): platform.machine(),
            (0x100A, 0): __version__,
            (0x1015, 0): round(settings.emcy_inhibit_s * 1e4),
            (0x1018, 4): settings.serial_number,
            (0x2001, 1): settings.ins_node_id,
            (0x2001, 2): _milliseconds(nav.stale_s),
            (0x2001, 3): _milliseconds(nav.clock_jump_s),
            (0x2001, 4): _milliseconds(nav.can.silence_s),
            (0x2001, 5): int(settings.start_ins),
        }

    def read(self, index: int, subindex: int, od: ODVariable, **_: Any) -> int | str | None:
        """Return the value of an object, None when the EDS has it."""
        if index == ERROR_REGISTER:
            return self._errors.register
        if index == ERROR_HISTORY:
            return self._error(subindex)
        if index == CONSUMER_HEARTBEAT and subindex:
            return self._ins_node_id << 16 | min(self._monitor.timeout_ns // MS, MAX_HEARTBEAT_MS)
        if index == COUNTER_VALUES and subindex:
            return self._counters[od.name] & MASK_32_BIT
        return self._constants.get((index, subindex))

    def write(self, index: int, subindex: int, data: bytes, **_: Any) -> None:
        """Take a value written by SDO; the EDS says what may be, and canopen has compared the length."""
        if index == ERROR_HISTORY:
            if any(data):
                raise SdoAbortedError(OUT_OF_RANGE)
            self._errors.history.clear()
        elif index == CONSUMER_HEARTBEAT:
            period_ms, node_id = struct.unpack("<HH", data)
            if node_id != self._ins_node_id:
                raise SdoAbortedError(OUT_OF_RANGE)
            self._monitor.timeout_ns = period_ms * MS

    def _error(self, subindex: int) -> int:
        history = self._errors.history
        if subindex == 0:
            return len(history)
        if subindex > len(history):
            raise SdoAbortedError(NO_DATA)
        return history[subindex - 1]


def _milliseconds(seconds: float) -> int:
    return min(round(1e3 * seconds), MASK_32_BIT)
