"""A state as a piece of text that fits into a link, and back. What comes from a link is anybody's."""

import base64
import binascii
import json
import zlib

import msgspec

from ods.base.errors import OdsError
from ods.workbench.model.paths import PathError, typed
from ods.workbench.model.short_tables import short_tables
from ods.workbench.model.state import State, Tuning

LONGEST_TEXT = 64_000
"""Characters; browsers take longer links, people do not."""
LONGEST_JSON = 2_000_000
"""Bytes that a text may unpack to."""


class ShareError(OdsError):
    """A text is no state; its own text is one line."""


def shared_text(state: State) -> str:
    """Return a state as text of letters, digits, `-` and `_`: only what is not as by default."""
    packed = zlib.compress(json.dumps(short_tables(state), separators=(",", ":")).encode(), 9)
    return base64.urlsafe_b64encode(packed).decode().rstrip("=")


def state_of(text: str, trusted: State) -> State:
    """Return the state of a text. Raises ShareError.

    Files of code and of maps are those of `trusted`, whatever the text says: a link must not choose what is run.
    """
    if len(text) > LONGEST_TEXT:
        raise ShareError(f"link: longer than {LONGEST_TEXT} characters")
    try:
        packed = base64.b64decode(text + "=" * (-len(text) % 4), altchars=b"-_", validate=True)
        unpacking = zlib.decompressobj()
        tables = json.loads(unpacking.decompress(packed, LONGEST_JSON))
        if unpacking.unconsumed_tail:
            raise ShareError(f"link: unpacks to more than {LONGEST_JSON} bytes")
        return _with_trusted_files(typed(tables, State), trusted)
    except (binascii.Error, zlib.error, ValueError, RecursionError, PathError) as error:
        raise ShareError(f"link: not a state of the workbench: {' '.join(str(error).split())[:200]}") from error


def _with_trusted_files(state: State, trusted: State) -> State:
    replace = msgspec.structs.replace
    own = trusted.tuning.config

    def repaired(tuning: Tuning) -> Tuning:
        pipeline = replace(tuning.config.pipeline, plugins=own.pipeline.plugins)
        tracker = replace(tuning.config.tracker, plugins=own.tracker.plugins, map=own.tracker.map)
        return replace(tuning, config=replace(tuning.config, pipeline=pipeline, tracker=tracker))

    further = tuple(map(repaired, state.further))
    return replace(state, tuning=repaired(state.tuning), other=state.other and repaired(state.other), further=further)
