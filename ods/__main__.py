"""`python -m ods`: the `ods` command. As with `ods` itself, nothing is imported from the current folder."""

import sys
from pathlib import Path

if not sys.flags.safe_path and sys.path[0] == str(Path.cwd()):
    del sys.path[0]  # or whoever can write there has his numpy.py run

from ods.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
