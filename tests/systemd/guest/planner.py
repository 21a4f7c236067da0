"""In the guest: a path planner that waits for a valid obstacle list, prints the last list that it got, and ends."""

import json
import sys
import time

from ods.client import Obstacles


def main(patience_s: float) -> None:
    """Print, as JSON: whether the list is valid and why not, the obstacles, seconds since power-on."""
    end_s = time.monotonic() + patience_s
    for picture in Obstacles("/run/ods"):
        if (picture.valid and picture.obstacles) or time.monotonic() > end_s:
            break
    obstacles = [obstacle.position_ned for obstacle in picture.obstacles]
    print(json.dumps([picture.valid, picture.reasons, obstacles, time.clock_gettime(time.CLOCK_BOOTTIME)]))


if __name__ == "__main__":
    main(float(sys.argv[1]))
