"""The one part of the build that pyproject.toml cannot say: all kernels, in C, make one extension module."""

import platform
from pathlib import Path

import numpy as np
from setuptools import Extension, setup

ARCHITECTURE = {"x86_64": ["-march=x86-64-v3", "-mtune=generic"]}
"""Of the processors that a wheel is for: x86-64 with AVX2 (2013 and later); others as the compiler takes them."""
REORDERED_SUMS = ["-fassociative-math", "-fno-signed-zeros", "-fno-trapping-math", "-freciprocal-math", "-ffp-contract=fast"]
"""So that they vectorise. Not -ffinite-math-only: bad samples must compare as false."""

native = Extension(
    "ods.compiled.native",
    sources=sorted(map(str, Path("ods").rglob("*.c"))),
    depends=sorted(map(str, Path("ods").rglob("*.h"))),
    include_dirs=[".", "ods/compiled", np.get_include()],
    extra_compile_args=["-std=c11", "-O3", "-g0", "-fno-math-errno", "-fvisibility=hidden", *REORDERED_SUMS, *ARCHITECTURE.get(platform.machine(), [])],
    py_limited_api=True,
)

setup(ext_modules=[native], options={"bdist_wheel": {"py_limited_api": "cp311"}})
