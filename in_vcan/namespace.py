"""On this host's kernel, in a network namespace of the command's own: no root needed, no other CAN traffic in it."""

import subprocess
import sys

from in_vcan import links
from in_vcan.job import Job, NotHereError, say
from in_vcan.keeper import keep

UNSHARE = ["unshare", "--user", "--map-root-user", "--net"]


def run(job: Job) -> int:
    """Run the job in a private user and network namespace, as root of that namespace. Raises NotHereError."""
    inside = [*UNSHARE, sys.executable, "-I", "-S", links.__file__]
    try:
        trial = subprocess.run([*inside, "true"], capture_output=True, text=True)
    except OSError as error:
        raise NotHereError(f"unshare: {error.strerror}") from error
    if trial.returncode:
        raise NotHereError(trial.stderr.strip().partition("\n")[0])
    say("in a private network namespace of this host")
    return keep([*inside, *job.command], job.timeout_s, [])
