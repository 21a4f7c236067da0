"""Keeps what numba has compiled as machine code for processes without numba (machine_code.py)."""

import os
import pickle
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ods.compiled.kernel import DISPATCHERS
from ods.compiled.machine_code import FILE, MachineCode, Variant, this_computer
from ods.compiled.type_names import name_of_type


def keep(folder: Path, job: str, before: MachineCode | None) -> Path:
    """Write all that numba has compiled in this process, and what is there `before`, to a file in `folder`.

    job: digest of the settings for which nothing is missing then. Raises OSError.
    """
    kernels = {} if before is None else dict(before.kernels)
    for name, dispatcher in DISPATCHERS.items():
        variants = {variant.types: variant for variant in (*kernels.get(name, ()), *_variants(dispatcher))}
        if variants:
            kernels[name] = tuple(variants.values())
    jobs = {job} if before is None else before.jobs | {job}
    return _write(folder / FILE, MachineCode(this_computer(), frozenset(jobs), kernels))


def _variants(dispatcher: Any) -> Iterator[Variant]:
    """Yield what numba's own cache holds of a kernel."""
    cache = dispatcher._cache
    for signature, result in dispatcher.overloads.items():
        kept = cache._cache_file.load(cache._index_key(signature, result.target_context.codegen()))
        if kept is not None:
            library, descriptor, environment, *_, called = kept
            constants = {each.env_name: list(each.consts) for each in (environment, *called)}
            yield Variant(
                tuple(map(name_of_type, signature)),
                descriptor.llvm_cpython_wrapper_name,
                descriptor.env_name,
                constants,
                library[2][0],
            )


def _write(file: Path, code: MachineCode) -> Path:
    """Write a file that all may read, whole or not at all."""
    new = file.with_suffix(f".{os.getpid()}")
    new.write_bytes(pickle.dumps(code))
    new.chmod(0o644)
    file.parent.chmod(0o755)
    return new.replace(file)
