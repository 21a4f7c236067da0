"""Libraries that have done their work: which parts go, and that they can be used all the same."""

import subprocess
import sys

from ods.base.resident import clean_parts

TOLD = """\
1000-3000 r-xp 00000000 08:01 12 /lib/libsome.so
Rss:                   8 kB
Anonymous:             0 kB
3000-4000 r--p 00002000 08:01 12 /lib/libsome.so
Anonymous:             4 kB
5000-6000 r--p 00000000 08:01 13 /libsome/libother.so
Anonymous:             0 kB
7000-8000 rw-p 00000000 00:00 0
Anonymous:             0 kB
9000-a000 r--p 00003000 08:01 12 /lib/libsome.so
Anonymous:             0 kB
"""
USE = """
import psutil
from llvmlite import binding
from ods.base.resident import give_back
here = psutil.Process()
def use():
    binding.initialize_native_target()
    machine = binding.Target.from_default_triple().create_target_machine()
    return len(machine.emit_assembly(binding.parse_assembly("define i32 @f() { ret i32 7 }")))
binding.initialize_native_asmprinter()
said, before = use(), here.memory_info().rss
give_back("llvmlite")
after = here.memory_info().rss
assert use() == said
print(before - after)
"""


def test_what_was_written_to_and_other_files_stay() -> None:
    assert list(clean_parts(TOLD, "libsome")) == [(0x1000, 0x3000), (0x9000, 0xA000)]
    assert list(clean_parts(TOLD, "none")) == []


def test_a_library_that_was_given_back_still_works() -> None:
    given = subprocess.run([sys.executable, "-c", USE], capture_output=True, text=True, check=True).stdout
    assert int(given) > 10_000_000
