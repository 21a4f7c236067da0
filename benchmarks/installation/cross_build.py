"""`python -m benchmarks.installation.cross_build`: do the kernels compute on 64-bit ARM what they compute here?

All C files are compiled by Debian's cross compiler for any 64-bit ARM, without a warning, and run in qemu-user on the
calls that the tests make here. Sums come in another order, and the libraries' functions differ in the last digit, so
floats are compared by the largest difference over the largest value of their array; where a threshold then falls the
other way, a share of the whole numbers and truth values differs.
"""

import argparse
import os
import pickle
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Iterator
from distutils.core import run_setup
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from benchmarks.installation.kernel_calls import Made
from ods.compiled import native

PACKAGES = "gcc-aarch64-linux-gnu libc6-dev-arm64-cross qemu-user"
"""Of Debian."""
COMPILER, EMULATOR, MARCH = "aarch64-linux-gnu-gcc", "qemu-aarch64", "armv8-a"
WARNINGS = ("-Wall", "-Wextra", "-Werror")
TESTS = ("tests/pipeline", "tests/tracker", "tests/sim_sonar")
RELATIVE = {"f4": 1e-4, "f8": 1e-6}
"""Differences of floats that are let pass, by their type."""
SHARE = 0.002
"""Likewise of elements that are no floats."""
BINDING = "ods/compiled/binding.c"


class Difference(NamedTuple):
    """Between two arrays."""

    relative: float
    share: float
    """Of elements that are no floats."""
    allowed: float

    @property
    def passes(self) -> bool:
        """Whether it is one of rounding."""
        return self.relative <= self.allowed and self.share <= SHARE


def main() -> None:
    """Compile, run, compare, print; exit code 1 where something differs by more than rounding."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("tests", nargs="*", default=TESTS, help=f"whose calls are taken (default: {' '.join(TESTS)})")
    args = parser.parse_args()
    missing = [name for name in (COMPILER, EMULATOR) if shutil.which(name) is None]
    if missing:
        raise SystemExit(f"not installed: {', '.join(missing)}; apt-get install {PACKAGES}")
    with tempfile.TemporaryDirectory(prefix="ods-cross-") as name:
        folder = Path(name)
        program = _compiled(folder)
        made = _noted_calls(folder, args.tests)
        subprocess.run([EMULATOR, program, folder / "calls.bin", folder / "made.bin"], check=True)
        raise SystemExit(_told(made, (folder / "made.bin").read_bytes()))


def _compiled(folder: Path) -> Path:
    """Return the program that runs calls. The binding is compiled, too, and not linked: there is no Python."""
    extension: Any = run_setup("setup.py", stop_after="init").ext_modules[0]
    options = [option for option in extension.extra_compile_args if not option.startswith("-march")]
    include = [f"-I{path}" for path in (*extension.include_dirs, sysconfig.get_path("include"))]
    command = [COMPILER, *options, f"-march={MARCH}", *WARNINGS, *include]
    objects = []
    for number, source in enumerate([*extension.sources, "benchmarks/installation/cross_build.c"]):
        target = folder / f"{number}.o"
        subprocess.run([*command, "-fPIC", "-c", source, "-o", target], check=True)
        if source == BINDING:
            symbols = subprocess.run(["nm", target], capture_output=True, text=True, check=True).stdout
            assert " T PyInit_native" in symbols
        else:
            objects.append(target)
    program = folder / "cross_build"
    subprocess.run([COMPILER, "-static", *objects, "-lm", "-o", program], check=True)
    print(f"{len(objects)} C files compiled for {MARCH} without a warning, and {BINDING}")
    return program


def _noted_calls(folder: Path, tests: tuple[str, ...]) -> list[Made]:
    command = [
        sys.executable,
        "-m",
        "pytest",
        "-p",
        "benchmarks.installation.kernel_calls",
        "-p",
        "no:cacheprovider",
        "-m",
    ]
    environment = os.environ | {"ODS_KERNEL_CALLS": str(folder)}
    subprocess.run([*command, "not slow", *tests], env=environment, check=False)
    return [Made(*each) for each in pickle.loads((folder / "made.pickle").read_bytes())]


def _told(made: list[Made], there: bytes) -> int:
    """Print what differs, and return the exit code."""
    offset, wrong, exact, largest = 0, 0, 0, [0.0, 0.0]
    for call in made:
        same = call.returned is None or _returned(there[offset : offset + 8], call.returned)
        offset += 8
        worst: list[Difference] = []
        for here in filter(lambda array: array is not None, call.arrays):
            assert here is not None
            there_too = np.frombuffer(there, here.dtype, here.size, offset).reshape(here.shape)
            offset += here.nbytes
            worst += _differences(here, there_too)
        exact += same and not any(each.relative or each.share for each in worst)
        relative, share = (max((each[k] for each in worst), default=0.0) for k in (0, 1))
        largest = [max(largest[0], relative), max(largest[1], share)]
        if not same or not all(each.passes for each in worst):
            wrong += 1
            other = "" if same else "returns something else; "
            print(f"{call.kernel}: {other}{relative:.1e} of the largest, {share:.2%} of the others")
    called = {call.kernel for call in made}
    never = sorted({name for name in dir(native) if not name.startswith("_")} - called)
    print(f"{len(made)} calls of {len(called)} kernels: {exact} to the bit, {wrong} differ by more than rounding")
    print(f"at most {largest[0]:.1e} of an array's largest value, and {largest[1]:.2%} of what is no float")
    if never:
        print(f"never called: {', '.join(never)}")
    return 1 if wrong else 0


def _returned(there: bytes, here: float) -> bool:
    """Whether the 8 bytes are the number, whole or not."""
    whole, number = int.from_bytes(there, "little", signed=True), float(np.frombuffer(there, np.float64)[0])
    return whole == here or bool(np.isclose(number, here, rtol=1e-6, equal_nan=True))


def _differences(here: "np.ndarray[Any, Any]", there: "np.ndarray[Any, Any]") -> Iterator[Difference]:
    if here.dtype.names:
        for name in here.dtype.names:
            yield from _differences(here[name], there[name])
    elif here.size == 0:
        return
    elif here.dtype.kind == "f":
        finite = np.isfinite(here)
        scale = np.abs(here[finite]).max(initial=0.0) or 1.0
        apart = np.abs(here[finite] - there[finite]).max(initial=0.0) / scale
        same = (here == there) | (np.isnan(here) & np.isnan(there))
        share = float(np.mean(~same & ~finite))
        yield Difference(float(apart), share, RELATIVE[here.dtype.str[1:]])
    else:
        yield Difference(0.0, float(np.mean(here != there)), 0.0)


if __name__ == "__main__":
    main()
