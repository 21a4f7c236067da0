"""`python -m ods`: the `ods` command."""

from ods.cli import main

if __name__ == "__main__":
    raise SystemExit(main())
