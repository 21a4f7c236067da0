"""In User-mode Linux: a Linux kernel as an ordinary process. No root, no virtual machine; x86-64 only.

It runs the guest's programs as traced children. One CPU; a system call costs about 10 us, a page fault 50 us.
"""

import ctypes
import os
import platform
import random
import shutil
import signal
import subprocess
from dataclasses import dataclass
from pathlib import Path

from in_vcan import boot, debian, modules
from in_vcan.job import Job, NotHereError

PROGRAM = "linux.uml"
PACKAGE = "user-mode-linux"
MEMORY_MB = 2048
"""A sparse file: only what is used counts."""
AMX_SINCE = (6, 13)
"""Older kernels' User-mode Linux does not know the size of the CPU state of Intel's AMX."""


@dataclass(frozen=True)
class Kernel:
    """User-mode Linux as it is on this machine."""

    program: Path
    version: str
    modules: Path
    """The folder of its modules."""

    def words(self, folder: Path, memory_mb: int = MEMORY_MB) -> list[str]:
        """Return the start of its command line; `folder`: private, for its sockets."""
        cpu = random.choice(list(os.sched_getaffinity(0)))
        return [
            # kernel and processes of the guest on one CPU: a system call then costs 12 us, not 46
            *("taskset", "-c", str(cpu), "env", f"TMPDIR={_memory_folder(memory_mb)}", str(self.program)),
            *(f"mem={memory_mb}M", f"uml_dir={folder}/", "umid=uml", "quiet"),
        ]


def run(job: Job) -> int:
    """Run the job in User-mode Linux. Raises NotHereError."""
    kernel = usable_kernel()

    def command(boot_run: boot.Run) -> list[str]:
        return [
            *kernel.words(boot_run.folder),
            *("root=/dev/root", "rootfstype=hostfs", "rootflags=/", "rw", f"init={boot_run.init}"),
            *("con=null", "con0=null,fd:1", f"con1=null,fd:{boot_run.stdout}", f"con2=null,fd:{boot_run.stderr}"),
        ]

    name, streams = f"User-mode Linux {kernel.version}", ("/dev/tty1", "/dev/tty2")
    return boot.run(job, boot.Machine(name, command, streams, modules.in_order(kernel.modules, modules.CAN)))


def usable_kernel() -> Kernel:
    """Return the kernel that this machine can run. Raises NotHereError."""
    if platform.machine() != "x86_64":
        raise NotHereError(f"User-mode Linux is for x86_64, not {platform.machine()}")
    if not _may_trace():
        raise NotHereError("tracing of processes (ptrace) is forbidden here")
    program = _program()
    version = subprocess.run([program, "--version"], capture_output=True, text=True).stdout.strip()
    if has_amx(Path("/proc/cpuinfo").read_text()) and _number(version) < AMX_SINCE:
        raise NotHereError(f"User-mode Linux {version} fails on a CPU with AMX")
    return Kernel(program, version, program.parents[1] / "lib" / "uml" / "modules" / version)


def has_amx(cpu_info: str) -> bool:
    """Tell whether /proc/cpuinfo names Intel's Advanced Matrix Extensions."""
    return "amx_tile" in cpu_info.split()


def _program() -> Path:
    """Return the kernel of the installed package, else of one unpacked in the cache."""
    installed = shutil.which(PROGRAM)
    return Path(installed) if installed else debian.unpacked(PACKAGE) / "usr" / "bin" / PROGRAM


def _number(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in version.split(".")[:2] if part.isdecimal())


def _may_trace() -> bool:
    """Try it: containers' filters of system calls and the security module Yama forbid it in ways of their own."""
    child = os.fork()
    if child == 0:
        os._exit(1 if ctypes.CDLL(None).ptrace(0, 0, None, None) else 0)  # PTRACE_TRACEME
    status = os.waitpid(child, 0)[1]
    if os.WIFSTOPPED(status):
        os.kill(child, signal.SIGKILL)
        status = os.waitpid(child, 0)[1]
    return status == 0


def _memory_folder(memory_mb: int) -> str:
    """Return a folder for the guest's memory: in memory where there is room and programs may lie there."""
    try:
        shm = os.statvfs("/dev/shm")
    except OSError:
        return "/tmp"
    roomy = shm.f_bavail * shm.f_frsize >= memory_mb << 20
    return "/dev/shm" if roomy and not shm.f_flag & os.ST_NOEXEC and os.access("/dev/shm", os.W_OK) else "/tmp"
