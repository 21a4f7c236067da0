"""`python -m benchmarks.dbc_files FOLDER`: how many DBC files of a folder are refused, and why.

Each message is read as if it were mapped. A file is refused where none of its messages can be read: all else costs the
message that is at fault only.
"""

import argparse
from pathlib import Path

from ods.nav_bridge.dbc.file import DbcError, DbcText


def main() -> None:
    """Print the refused files and messages, and their counts."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").split("\n\n")[0])
    parser.add_argument("folder", type=Path)
    files = sorted(parser.parse_args().folder.rglob("*.dbc"))
    refused = messages = refused_messages = faulty = 0
    for file in files:
        try:
            text = DbcText(file)
        except DbcError as error:
            refused += 1
            print(error)
            continue
        faults = list(filter(None, (_fault(text, name) for name in text.names)))
        for fault in faults:
            print(fault)
        refused += bool(faults) and len(faults) == len(text.names)
        messages, refused_messages, faulty = (
            messages + len(text.names),
            refused_messages + len(faults),
            faulty + bool(faults),
        )
    told = f"{refused_messages} of {messages} messages, in {faulty} files, if they are mapped"
    print(f"refused: {refused} of {len(files)} files; {told}")


def _fault(text: DbcText, name: str) -> str:
    try:
        text.message(name)
    except DbcError as error:
        return str(error)
    return ""


if __name__ == "__main__":
    main()
