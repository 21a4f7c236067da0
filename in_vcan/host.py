"""On this host's own kernel: its vcan0 and vcan1, or ones made for the time of the command."""

from in_vcan import links
from in_vcan.job import Job, NotHereError, say
from in_vcan.keeper import keep


def run(job: Job) -> int:
    """Run the job on the host. Raises NotHereError."""
    try:
        made = links.ensure()
    except OSError as error:
        raise NotHereError(str(error)) from error
    say("on this host's vcan0 and vcan1")
    return keep(job.command, job.timeout_s, [[links.ip_program(), "link", "del", "dev", name] for name in made])
