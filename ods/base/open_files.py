"""How many files and sockets this process may have open."""

import resource

from ods.base.errors import OdsError

LEAST = 64
"""A process of a chain has up to 25 open, and one more for each who listens to it."""


class OpenFilesError(OdsError):
    """Too few may be open; the text says so in one line."""


def allow_enough() -> None:
    """Raise a limit that is too low, where one may, as libraries end the process at it. Raises OpenFilesError."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    if soft >= LEAST or soft == resource.RLIM_INFINITY:
        return
    if hard < LEAST and hard != resource.RLIM_INFINITY:
        raise OpenFilesError(f"only {hard} files may be open here: at least {LEAST} are needed, see `ulimit -n`")
    resource.setrlimit(resource.RLIMIT_NOFILE, (LEAST, hard))
