"""Ground truth of pings, as `ods simulate` writes it beside them."""

from pathlib import Path

import msgspec

from ods.base.errors import OdsError
from ods.base.files.in_file import MOST_BYTES, content_of
from ods.messages import Truth

TRUTH_SUFFIX = ".truth.jsonl"


def truths_beside(path: Path) -> dict[int, Truth]:
    """Return what `ods simulate` wrote beside a file, by ping number; empty where it did not. Raises OdsError."""
    file = path.with_suffix(TRUTH_SUFFIX)
    if not file.is_file():
        return {}
    try:
        truths = [msgspec.json.decode(line, type=Truth) for line in content_of(file, MOST_BYTES // 10).splitlines()]
    except (OSError, msgspec.MsgspecError, UnicodeDecodeError) as error:
        raise OdsError(f"{file}: {error}") from error
    return {truth.ping_number: truth for truth in truths}
