"""Kernel modules and what they depend on, read from the modules themselves: a package just unpacked has no index."""

import lzma
import re
from collections.abc import Iterator
from pathlib import Path

CAN = ("can-raw", "can-bcm", "can-gw", "vcan", "vxcan", "slcan")


def in_order(folder: Path, names: tuple[str, ...]) -> Iterator[tuple[str, bytes]]:
    """Yield name and content of the modules below `folder`, each after those it needs.

    What is not there is left out: kernels have built in what others have as modules.
    """
    files = {_plain(file.name.partition(".")[0]): file for file in folder.rglob("*.ko*")}
    seen: set[str] = set()

    def visit(written: str) -> Iterator[tuple[str, bytes]]:
        name = _plain(written)
        if name in seen or name not in files:
            return
        seen.add(name)
        content = _read(files[name])
        needs = re.search(rb"\0depends=([^\0]*)\0", content)
        for needed in needs[1].decode().split(",") if needs else ():
            yield from visit(needed)
        yield name, content

    for name in names:
        yield from visit(name)


def _plain(name: str) -> str:
    """Return a module's name as it is compared: hyphen and underscore are the same."""
    return name.replace("-", "_")


def _read(file: Path) -> bytes:
    content = file.read_bytes()
    return lzma.decompress(content) if file.suffix == ".xz" else content
