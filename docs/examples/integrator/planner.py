"""A planner with nothing but zmq and msgpack: prints a line of JSON for each list; asks for a range first, if told to.

python planner.py RUN_DIR LISTS [RANGE_M]
"""

import json
import sys
from typing import Any

import msgpack
import zmq


def set_range(context: "zmq.Context[zmq.Socket[bytes]]", run_dir: str, range_m: float) -> dict[str, Any]:
    """Return the sonar's answer."""
    with context.socket(zmq.REQ) as socket:
        socket.setsockopt(zmq.LINGER, 0)
        socket.setsockopt(zmq.RCVTIMEO, 10_000)
        socket.connect(f"ipc://{run_dir}/sonar-requests.sock")
        socket.send(msgpack.packb({"range_m": range_m}))
        answer: dict[str, Any] = msgpack.unpackb(socket.recv())
        return answer


def main(run_dir: str, lists: int, range_m: float | None) -> None:
    """Print what the tracker says."""
    with zmq.Context() as context, context.socket(zmq.SUB) as socket:
        socket.setsockopt(zmq.RCVTIMEO, 1000)
        socket.connect(f"ipc://{run_dir}/tracker.sock")
        socket.subscribe("obstacles")
        if range_m is not None:
            print(json.dumps({"answer": set_range(context, run_dir, range_m)}), flush=True)
        for _ in range(lists):
            try:
                _, body = socket.recv_multipart()
            except zmq.Again:
                print(json.dumps({"valid": False, "reasons": ["silence"], "positions": []}), flush=True)
                continue
            obstacle_list = msgpack.unpackb(body)
            positions = [o["position_ned"] for o in obstacle_list["obstacles"]]
            told = {"valid": obstacle_list["valid"], "reasons": obstacle_list["reasons"], "positions": positions}
            print(json.dumps(told), flush=True)


if __name__ == "__main__":
    main(sys.argv[1], int(sys.argv[2]), float(sys.argv[3]) if len(sys.argv) > 3 else None)
