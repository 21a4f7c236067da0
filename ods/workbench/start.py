"""Start of the workbench, by its command line."""

from argparse import Namespace
from functools import partial
from pathlib import Path

from ods.base.errors import OdsError
from ods.base.settings_file import load, load_table
from ods.config import OnboardConfig
from ods.sim_sonar.scene.settings import SceneFile
from ods.sonar_link.files.decoder import PLUGINS
from ods.sonar_link.files.settings import RecordingsSettings
from ods.workbench.engine.background import own_process
from ods.workbench.engine.files.config_file import ConfigFile
from ods.workbench.model.state import DataReference, State, Tuning


def first_state(args: Namespace, loaded: ConfigFile) -> State:
    """Return what each browser begins with. Raises ConfigError, PluginError, OdsError."""
    if args.config:
        recordings = load_table(args.config, "recordings", RecordingsSettings, OnboardConfig)
        load_plugins = partial(PLUGINS.load, recordings.plugins)
        load_plugins()
        own_process.at_first.append(load_plugins)
    tuning = Tuning(loaded.config)
    if args.live:
        if args.source:
            raise OdsError("--live: goes without a file")
        if args.live.exists() and not args.live.is_dir():  # one that is not there may yet be made
            raise OdsError(f"--live: {args.live} is no folder")
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
