"""`ods workbench`: the interactive environment, served to browsers on this machine."""

import os
import sys
import threading
import webbrowser
from argparse import ArgumentParser, Namespace
from pathlib import Path
from types import ModuleType
from typing import cast

from ods.base.command_line.arguments import port_number
from ods.base.computer.resident import use_one_arena

NO_STORAGE = Path(os.devnull) / "none"
"""Where NiceGUI would keep what pages store: nowhere."""
HANDOVER_S = 0.001
"""After which a thread that goes on gives way to one that has a picture: Python's own 5 ms come several times over."""
SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")
"""One is set where a browser can open a window; elsewhere one that writes into the terminal might start."""


def add_arguments(parser: ArgumentParser) -> None:
    """Data to open first, and where to serve."""
    parser.add_argument(
        "source", type=Path, nargs="?", metavar="FILE|DIR|SCENE.toml",
        help="any input of ods detect or ods track; a folder of segments; a scene",
    )  # fmt: skip
    parser.add_argument("--live", type=Path, metavar="RUN_DIR", help="show a vehicle's bus, read only")
    parser.add_argument("--port", type=port_number, metavar="N", help="on 127.0.0.1 (default: 8420, or any)")
    parser.add_argument(
        "--folder", type=Path, action="append", default=[], metavar="DIR",
        help="also allow opening and saving files there; otherwise only here and beside opened files",
    )  # fmt: skip
    parser.add_argument("--no-browser", action="store_true", help="only print the link")


def run(args: Namespace) -> None:
    """Serve until interrupted. Raises OdsError."""
    os.environ["NICEGUI_STORAGE_PATH"] = str(NO_STORAGE)  # read when NiceGUI is imported
    use_one_arena()
    sys.setswitchinterval(HANDOVER_S)
    from ods.workbench.engine.files.config_file import load_config
    from ods.workbench.session import Session
    from ods.workbench.start import first_state, folders_of

    loaded, folders = load_config(args.config), folders_of(args)
    state = first_state(args, loaded)
    cast("dict[str, ModuleType | None]", sys.modules).setdefault("aiohttp", None)  # 9 MB, for clients of Engine.IO only
    from ods.workbench.pages import frame  # takes a second: after what may be wrong
    from ods.workbench.web import server

    bound = server.listening(args.port)
    links: list[str] = []

    def announce(link: str) -> None:
        print(f"for another browser: {link}" if links else f"workbench: {link}", flush=True)
        if not links and not args.no_browser and any(os.environ.get(name) for name in SCREENS):
            threading.Thread(target=webbrowser.open, args=(link,), daemon=True).start()
        links.append(link)

    server.serve(server.Site(frame.build, lambda: Session(state, folders, loaded)), bound, announce)
