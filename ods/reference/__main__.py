"""Writes the generated pages into the folder named on the command line: `make docs`."""

import sys
from pathlib import Path

from ods.reference.pages import pages

for name, text in pages().items():
    file = Path(sys.argv[1]) / name
    file.parent.mkdir(exist_ok=True)
    file.write_text(text, encoding="utf-8")
