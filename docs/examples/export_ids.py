"""Lists as lines of text: UTC in ns, and the ids of the obstacles."""

from collections import Counter
from pathlib import Path

import msgspec

from ods.messages import ObstacleList


class IdsFile:
    """Writes a new file."""

    def __init__(self, path: Path) -> None:
        """Raises OSError."""
        self.losses: Counter[str] = Counter()
        self._file = path.open("x", encoding="utf-8")

    def take(self, stamp_ns: int, message: msgspec.Struct) -> None:
        """Write a list's line. Raises OSError."""
        if isinstance(message, ObstacleList):
            print(stamp_ns, *(obstacle.id for obstacle in message.obstacles), file=self._file)

    def close(self) -> None:
        """Raises OSError."""
        self._file.close()
