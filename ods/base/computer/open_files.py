"""Limit of open files and sockets of this process."""

import resource

from ods.base.errors import OdsError

LEAST = 64
"""A process of a chain has up to 25 open, and one more for each who listens to it."""
WANTED = 65_536
"""ZeroMQ ends the process at the limit; the usual one of 1024 was met by a planner that connected 1000 times."""


class OpenFilesError(OdsError):
    """The limit of open files is too low; the text is one line."""


def allow_enough() -> None:
    """Raise the limit as far as one may and it makes sense. Raises OpenFilesError where it is too low for all."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    most = WANTED if hard == resource.RLIM_INFINITY else min(hard, WANTED)
    if most < LEAST:
        raise OpenFilesError(f"the limit of open files is {most}: at least {LEAST} are needed, see `ulimit -n`")
    if soft != resource.RLIM_INFINITY and soft < most:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, hard))
