"""The message of the topic `raw`: bytes as received from a device."""

from typing import Annotated

import msgspec


class RawBytes(msgspec.Struct, frozen=True):
    """Bytes of one read from the sonar's port; published only with `sonar.publish_raw`."""

    seq: Annotated[int, msgspec.Meta(ge=0)]
    t_ns: int
    """When it was read."""
    data: bytes
