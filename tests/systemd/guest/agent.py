"""In the guest, as root: runs the commands that come on a serial line, one JSON line each, and answers likewise."""

import json
import subprocess
import tty
from pathlib import Path
from typing import Any

LINE = Path("/dev/ttyS1")


def answer(request: dict[str, Any]) -> dict[str, Any]:
    """Run the command; return its status, 124 when it took too long, and all that it printed."""
    try:
        done = subprocess.run(
            request["command"],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            timeout=request["timeout_s"],
        )
    except subprocess.TimeoutExpired as error:
        return {"status": 124, "output": (error.stdout or b"").decode(errors="replace")}
    return {"status": done.returncode, "output": done.stdout.decode(errors="replace")}


def main() -> None:
    """Answer until the guest ends."""
    with LINE.open("r+b", buffering=0) as line:
        tty.setraw(line.fileno())
        line.write(b"up\n")
        while request := line.readline():
            line.write(json.dumps(answer(json.loads(request))).encode() + b"\n")


if __name__ == "__main__":
    main()
