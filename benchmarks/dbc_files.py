"""`python -m benchmarks.dbc_files FOLDER`: how many DBC files of a folder are refused, and why.

Each file is read as the INS's would be, each message of it as if it were mapped: one that is refused costs itself only.
Aim: of the DBC files of commaai/opendbc at most 10 are refused as a whole.
"""

import argparse
from pathlib import Path

from ods.base.errors import one_line
from ods.nav_bridge.dbc.file import DbcError, read_database


def main() -> None:
    """Print the refused files and messages, and their counts."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("folder", type=Path)
    files = sorted(parser.parse_args().folder.rglob("*.dbc"))
    refused = messages = refused_messages = 0
    for file in files:
        try:
            found = read_database(file).messages
        except DbcError as error:
            refused += 1
            print(error)
            continue
        messages += len(found)
        for message in found:
            try:
                message.refresh(strict=True)
            except Exception as error:  # cantools' own
                refused_messages += 1
                print(f"{file.name}: {one_line(error)}")
    print(
        f"{refused} of {len(files)} files refused; in the others {refused_messages} of {messages} messages, if mapped"
    )


if __name__ == "__main__":
    main()
