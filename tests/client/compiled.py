"""Planners in C and C++, compiled with the libzmq that pyzmq brings."""

import shutil
import subprocess
from pathlib import Path

import pytest
import zmq

ROOT = Path(__file__).parents[2]
CLIENT = ROOT / "client"
ZMQ_HEADER = """
#define ZMQ_SUB 2
#define ZMQ_SUBSCRIBE 6
#define ZMQ_RCVTIMEO 27
#include <stddef.h>
typedef struct { unsigned char _[64] __attribute__((aligned(8))); } zmq_msg_t;
#ifdef __cplusplus
extern "C" {
#endif
void *zmq_ctx_new(void); int zmq_ctx_term(void *); void *zmq_socket(void *, int); int zmq_close(void *);
int zmq_setsockopt(void *, int, const void *, size_t); int zmq_connect(void *, const char *);
int zmq_msg_init(zmq_msg_t *); int zmq_msg_recv(zmq_msg_t *, void *, int); int zmq_msg_close(zmq_msg_t *);
void *zmq_msg_data(zmq_msg_t *); size_t zmq_msg_size(const zmq_msg_t *);
#ifdef __cplusplus
}
#endif
"""
"""What the planners use of zmq.h, whose package need not be installed: the library is that of pyzmq."""
FLAGS = ["-Wall", "-Wextra", "-Werror", "-O1", "-Wl,--allow-shlib-undefined"]


def compiled(compiler: str, source: Path, folder: Path, *more: str) -> Path:
    """Return the program of a source; skips the test where there is no compiler, or no libzmq."""
    if shutil.which(compiler) is None:
        pytest.skip(f"no compiler {compiler} here")
    found = sorted(Path(zmq.__file__).parents[1].glob("pyzmq.libs/libzmq*"))
    if not found:
        pytest.skip("pyzmq was built without a libzmq of its own")
    (folder / "zmq.h").write_text(ZMQ_HEADER)
    program, library = folder / source.stem, found[0]
    paths = [f"-I{folder}", f"-I{CLIENT}", f"-Wl,-rpath,{library.parent}"]
    subprocess.run([compiler, *FLAGS, *paths, *more, "-o", program, source, library], check=True)
    return program
