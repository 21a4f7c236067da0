"""`ods workbench`: the interactive environment, served to browsers on this machine."""

import os
import threading
import webbrowser
from argparse import ArgumentParser, Namespace
from pathlib import Path

from ods.base.arguments import port_number
from ods.base.errors import OdsError
from ods.base.settings_file import load
from ods.config import OnboardConfig, part_of
from ods.offline.mission import MissionSettings
from ods.sim_sonar.scene.settings import SceneFile
from ods.sonar_link.files.decoder import PLUGINS
from ods.workbench.model.state import DataReference, State, Tuning
from ods.workbench.session import Session

NO_STORAGE = Path(os.devnull) / "none"
"""Where NiceGUI would keep what pages store: nowhere."""
SCREENS = ("DISPLAY", "WAYLAND_DISPLAY")
"""One is set where a browser can open a window; elsewhere one that writes into the terminal might start."""


def add_arguments(parser: ArgumentParser) -> None:
    """What is opened first, and where it is served."""
    parser.add_argument(
        "source", type=Path, nargs="?", metavar="FILE|DIR|SCENE.toml",
        help="whatever ods detect or ods track read; a folder of segments; a scene",
    )  # fmt: skip
    parser.add_argument("--live", type=Path, metavar="RUN_DIR", help="look at a vehicle's bus, read only")
    parser.add_argument("--port", type=port_number, metavar="N", help="on 127.0.0.1 (default: 8420, or any)")
    parser.add_argument(
        "--folder", type=Path, action="append", default=[], metavar="DIR",
        help="files may be opened and saved there, too; else only here and beside what is opened",
    )  # fmt: skip
    parser.add_argument("--no-browser", action="store_true", help="only print the link")


def run(args: Namespace) -> None:
    """Serve until interrupted. Raises OdsError."""
    state, folders = first_state(args), folders_of(args)
    os.environ["NICEGUI_STORAGE_PATH"] = str(NO_STORAGE)  # read when NiceGUI is imported
    from ods.workbench.pages import frame
    from ods.workbench.web import server

    bound = server.listening(args.port)
    told: list[str] = []

    def tell(link: str) -> None:
        print(f"for another browser: {link}" if told else f"workbench: {link}", flush=True)
        if not told and not args.no_browser and any(os.environ.get(name) for name in SCREENS):
            threading.Thread(target=webbrowser.open, args=(link,), daemon=True).start()
        told.append(link)

    server.serve(server.Site(frame.build, lambda: Session(state, folders)), bound, tell)


def first_state(args: Namespace) -> State:
    """Return what each browser begins with. Raises ConfigError, PluginError, OdsError."""
    tuning = Tuning()
    if args.config:
        config = load(args.config, OnboardConfig)
        PLUGINS.load(config.recordings.plugins)
        tuning = Tuning(part_of(config, MissionSettings))
    if args.live:
        if args.source:
            raise OdsError("--live: goes without a file")
        return State(tuning, data=DataReference("live", str(args.live.resolve())))
    if not args.source:
        return State(tuning)
    if not args.source.exists():
        raise OdsError(f"{args.source}: no such file or folder")
    path = str(args.source.resolve())
    if args.source.suffix == ".toml":
        return State(tuning, data=DataReference("scene", path), scene=load(args.source, SceneFile))
    return State(tuning, data=DataReference("file", path))


def folders_of(args: Namespace) -> tuple[Path, ...]:
    """Return the folders that files may be opened and saved in. Raises OdsError for one that is not there."""
    given = [folder.resolve() for folder in args.folder]
    for folder in given:
        if not folder.is_dir():
            raise OdsError(f"--folder: {folder}: no such folder")
    beside = [path.resolve().parent for path in (args.source, args.config) if path]
    return tuple(dict.fromkeys([Path.cwd().resolve(), *beside, *given]))
