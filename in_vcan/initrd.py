"""The initial RAM disk of the QEMU guest: inserts modules, and makes the host's files (9p) the root."""

from collections.abc import Iterable

INIT = """#!/busybox sh
for module in /modules/*; do /busybox insmod $module; done
/busybox mount -t 9p -o trans=virtio,version=9p2000.L,msize=512000,cache=loose host /root
exec /busybox switch_root /root "$1"
"""
FOLDER, PROGRAM, FILE, CONSOLE = 0o040755, 0o100755, 0o100644, 0o020600


def initrd(busybox: bytes, modules: Iterable[tuple[str, bytes]]) -> bytes:
    """Return a cpio archive ("newc", Documentation/driver-api/early-userspace/buffer-format.rst of the kernel)."""
    members = [
        _member("dev", FOLDER),
        _member("dev/console", CONSOLE, device=(5, 1)),
        _member("modules", FOLDER),
        _member("root", FOLDER),
        _member("busybox", PROGRAM, busybox),
        _member("init", PROGRAM, INIT.encode()),
    ]
    members += [_member(f"modules/{place:02d}-{name}", FILE, content) for place, (name, content) in enumerate(modules)]
    return b"".join([*members, _member("TRAILER!!!", 0)])


def _member(name: str, mode: int, content: bytes = b"", device: tuple[int, int] = (0, 0)) -> bytes:
    path = name.encode() + b"\0"
    fields = (0, mode, 0, 0, 1, 0, len(content), 0, 0, *device, len(path), 0)
    head = b"070701" + b"".join(b"%08x" % field for field in fields) + path
    return _padded(head) + _padded(content)


def _padded(data: bytes) -> bytes:
    return data + bytes(-len(data) % 4)
