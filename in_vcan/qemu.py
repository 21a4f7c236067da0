"""In QEMU, with Debian's kernel and the host's files by 9p: slow, but it asks nothing of the CPU, and no ptrace."""

import platform
import shutil
from pathlib import Path

from in_vcan import boot, debian, modules
from in_vcan.initrd import initrd
from in_vcan.job import Job, NotHereError

PROGRAM = "qemu-system-x86_64"
PACKAGE = "qemu-system-x86"
KERNEL = "linux-image-amd64"
"""Not the "cloud" kernel, which has no CAN."""
ROOT = ("virtio_pci", "virtio_console", "9pnet_virtio", "9p")
MEMORY_MB = 2048
CPUS = 2
"""Each is emulated in a thread of its own: a chain of four processes cannot keep up on one."""
NO_SOCKETS = {"TMPDIR": "/dev/shm"}
"""QEMU's file server cannot make sockets, so programs get a folder for them in the guest's memory."""


def run(job: Job) -> int:
    """Run the job in QEMU. Raises NotHereError."""
    if platform.machine() != "x86_64":
        raise NotHereError(f"Debian's amd64 kernel is for x86_64, not {platform.machine()}")
    if not shutil.which(PROGRAM):
        debian.install(PACKAGE)
    kernel = _kernel()

    def command(boot_run: boot.Run) -> list[str]:
        (boot_run.folder / "initrd").symlink_to(kernel / "initrd")
        return [
            *(PROGRAM, "-nodefaults", "-no-user-config", "-display", "none", "-no-reboot", "-serial", "stdio"),
            *("-accel", "tcg,thread=multi", "-cpu", "max", "-smp", str(CPUS), "-m", f"{MEMORY_MB}M"),
            *("-kernel", str(kernel / "vmlinuz"), "-initrd", str(kernel / "initrd")),
            *("-append", f"console=ttyS0 quiet panic=-1 mitigations=off -- {boot_run.init}"),
            *("-fsdev", "local,id=host,path=/,security_model=none,multidevs=remap"),
            *("-device", "virtio-serial-pci", "-device", "virtio-9p-pci,fsdev=host,mount_tag=host"),
            *_port(1, boot_run.stdout),
            *_port(2, boot_run.stderr),
        ]

    name = f"QEMU with Linux {(kernel / 'version').read_text()}"
    return boot.run(job, boot.Machine(name, command, ("/dev/vport0p1", "/dev/vport0p2"), environment=NO_SOCKETS))


def _port(number: int, descriptor: int) -> list[str]:
    """Return the options of a binary-clean serial port whose data go to one of QEMU's open files."""
    return [
        *("-chardev", f"file,id=port{number},path=/proc/self/fd/{descriptor}"),
        *("-device", f"virtserialport,nr={number},chardev=port{number}"),
    ]


def _kernel() -> Path:
    """Return the folder with `vmlinuz`, `initrd` and `version`: of the kernel's package, no more than is needed."""
    folder = debian.cache() / "kernel"
    if not folder.exists():
        debian.unpacked(KERNEL)  # brings the lists of packages as well
        package = next(iter(debian.depends(KERNEL)), None)
        if package is None:
            raise NotHereError(f"the package {KERNEL} names no kernel")
        root, busybox = debian.unpacked(package), debian.unpacked("busybox-static")
        (modules_folder,) = (root / "lib" / "modules").iterdir()
        found = list(modules.in_order(modules_folder, ROOT + modules.CAN))
        scratch = debian.cache() / "kernel.new"
        scratch.mkdir(exist_ok=True)
        (scratch / "version").write_text(modules_folder.name)
        (scratch / "initrd").write_bytes(initrd((busybox / "bin" / "busybox").read_bytes(), found))
        next((root / "boot").glob("vmlinuz-*")).rename(scratch / "vmlinuz")
        scratch.rename(folder)
        shutil.rmtree(root)
    return folder
