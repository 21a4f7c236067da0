"""The part of the build that pyproject.toml cannot say: all kernels, in C, make one extension module.

`ODS_MARCH` names another processor than `_MARCH`, as gcc's `-march` does: `native`, `x86-64-v4`. `ODS_CFLAGS` are
options after all others, `LDFLAGS` those of the linker (`make sanitize`).
"""

import os
import platform
from pathlib import Path

import numpy as np
from setuptools import Extension, setup

_MARCH = {"x86_64": "x86-64-v3", "aarch64": "armv8-a"}
"""What a wheel is for: 64-bit x86 with AVX2 (2013 and later), any 64-bit ARM."""
_REORDERED_SUMS = ["-fassociative-math", "-fno-signed-zeros", "-fno-trapping-math", "-freciprocal-math"]
"""So that they vectorise. Not -ffinite-math-only: bad samples must compare as false."""

_march = os.environ.get("ODS_MARCH") or _MARCH.get(platform.machine())
_native = Extension(
    "ods.compiled.native",
    sources=sorted(map(str, Path("ods").rglob("*.c"))),
    depends=sorted(map(str, Path("ods").rglob("*.h"))),
    include_dirs=[".", "ods/compiled", np.get_include()],
    extra_compile_args=[
        "-std=c11", "-O3", "-g0", "-fno-math-errno", "-ffp-contract=fast", "-fvisibility=hidden", *_REORDERED_SUMS,
        *([f"-march={_march}"] if _march else []), *os.environ.get("ODS_CFLAGS", "").split(),
    ],
    py_limited_api=True,
)  # fmt: skip

setup(ext_modules=[_native], options={"bdist_wheel": {"py_limited_api": "cp311"}})
