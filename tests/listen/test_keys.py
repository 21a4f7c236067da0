"""`ods keys`, and key files that are refused in one line."""

import os
from pathlib import Path

import pytest
import zmq

from ods.base.settings_file import ConfigError, load
from ods.cli import main
from ods.client import Obstacles
from ods.client.remote import RemoteError
from ods.config import OnboardConfig
from ods.runtime import supervisor
from ods.runtime.keys.key_files import KeyFileError, read_client_key, read_pair
from ods.runtime.keys.key_folder import KeyFolder

ONBOARD = Path(__file__).parents[2] / "config" / "onboard.toml"
LISTEN = 'listen = [{at = "tcp://127.0.0.1:5600", topics = ["obstacles"]}]'


def config(folder: Path, bus: str) -> Path:
    file = folder / "onboard.toml"
    file.write_text(ONBOARD.read_text().replace("[bus]", f'[bus]\nrun_dir = "{folder}"\n{bus}'))
    return file


def keys(folder: Path, *words: str) -> int:
    return main(["keys", *words, "--config", str(config(folder, 'keys = "keys"'))])


def test_keys_are_made_listed_and_revoked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    before = os.umask(0)
    try:
        assert keys(tmp_path, "make", "planner") == 0
    finally:
        os.umask(before)
    folder = tmp_path / "keys"
    assert (folder.stat().st_mode & 0o777) == 0o700
    assert {file.name: file.stat().st_mode & 0o777 for file in folder.iterdir()} == {
        "server.secret": 0o600, "planner.secret": 0o600, "allowed": 0o600,
    }  # fmt: skip
    server, client = read_pair(folder / "server.secret"), read_client_key(folder / "planner.secret")
    assert client.server == server.public
    assert zmq.curve_public(client.own.secret.encode()).decode() == client.own.public
    public = zmq.curve_keypair()[0].decode()
    (tmp_path / "display.public").write_text(f"{public}\n")
    assert keys(tmp_path, "make", "display", "--public", str(tmp_path / "display.public")) == 0
    assert not (folder / "display.secret").exists()
    capsys.readouterr()
    assert keys(tmp_path, "list") == 0
    said = capsys.readouterr().out
    assert said.splitlines() == [
        f"{server.public}  this vehicle",
        f"{client.own.public}  planner (its secret is still here: {folder / 'planner.secret'})",
        f"{public}  display",
    ]
    assert client.own.secret not in said
    assert server.secret not in said
    assert keys(tmp_path, "revoke", "planner") == 0
    assert KeyFolder(folder).allowed() == {"display": public}
    assert not (folder / "planner.secret").exists()
    assert read_pair(folder / "server.secret") == server


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["make", "../server"], "../server: not a name: "),
        (["make", "server"], "server: not a name: "),
        (["make", "old"], "allowed: already has a old: revoke it, or use another name"),
        (["make", "new", "--public", __file__], "not a public key: expected 40 characters"),
        (["make", "new", "--public", "no.public"], "no.public: no such file or directory"),
        (["revoke", "new"], "allowed: has no new"),
    ],
)
def test_a_mistake_is_one_line(tmp_path: Path, capsys: pytest.CaptureFixture[str], words: list[str], said: str) -> None:
    KeyFolder(tmp_path / "keys").make("old")
    assert keys(tmp_path, *words) == 2
    reported = capsys.readouterr().err
    assert said in reported
    assert reported.count("\n") == 1


@pytest.mark.parametrize("mode", [0o640, 0o604, 0o660])
def test_a_secret_that_others_may_read_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mode: int
) -> None:
    secret = KeyFolder(tmp_path / "keys").make("planner")
    secret.chmod(mode)
    with pytest.raises(KeyFileError) as refused:
        Obstacles("tcp://127.0.0.1:5600", key=secret)
    assert str(refused.value) == f"{secret}: others have access to it: chmod 600 {secret}"
    server = tmp_path / "keys" / "server.secret"
    server.chmod(mode)
    assert main(["listen", "--config", str(config(tmp_path, f'keys = "keys"\n{LISTEN}'))]) == 2
    reported = capsys.readouterr().err
    assert reported.startswith(f"ods listen: bus.keys: {server}: others have access to it: chmod 600 {server}")
    assert reported.count("\n") == 1


def test_a_list_that_others_may_write_lets_nobody_in(tmp_path: Path) -> None:
    folder = KeyFolder(tmp_path / "keys")
    folder.make("planner")
    (folder.path / "allowed").chmod(0o620)
    with pytest.raises(KeyFileError, match="others have access to it"):
        folder.allowed()


@pytest.mark.parametrize(
    ("bus", "said"),
    [
        (LISTEN, 'bus.keys: missing: the folder in which `ods keys make` puts the keys, such as "keys"'),
        ('listen = [{at = "tcp://127.0.0.1:5600"}]', "bus.listen[0].topics: missing"),
        (LISTEN.replace("obstacles", "obstacle"), "bus.listen[0].topics: 'obstacle' is not one of ping, pose, "),
        (LISTEN.replace('"obstacles"', ""), "bus.listen[0].topics: must name at least one topic"),
        (LISTEN.replace("tcp://127.0.0.1:5600", "tcp://planner:5600"), "bus.listen[0].at: tcp://planner:5600: needs"),
        (LISTEN.replace("tcp://127.0.0.1:5600", "tcp://*:5600"), "bus.listen[0].at: tcp://*:5600: needs an"),
        (LISTEN.replace("tcp:", "udp:"), "bus.listen[0].at: udp://127.0.0.1:5600: expected an address and a port"),
        (LISTEN.replace("127.0.0.1", "239.1.1.1"), "bus.listen[0].at: tcp://239.1.1.1:5600: must be an address of"),
        (LISTEN.replace("5600", "0"), "bus.listen[0].at: tcp://127.0.0.1:0: expected an address and a port"),
    ],
)  # fmt: skip
def test_a_wrong_configuration_is_one_line_with_the_key(tmp_path: Path, bus: str, said: str) -> None:
    file = config(tmp_path, bus)
    with pytest.raises(ConfigError) as refused:
        load(file, OnboardConfig)
    assert str(refused.value).startswith(f"{file}: {said}")
    assert "\n" not in str(refused.value)


def test_none_listens_unless_it_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    started: list[str] = []
    monkeypatch.setattr(supervisor, "supervise", lambda processes, *_: started.extend(each.name for each in processes))
    assert main(["run", "--config", str(config(tmp_path, ""))]) == 0
    assert "listen" not in started
    assert main(["listen", "--is-on", "--config", str(config(tmp_path, ""))]) == 1
    file = config(tmp_path, f'keys = "keys"\n{LISTEN}')
    assert main(["run", "--config", str(file)]) == 0
    assert "listen" in started
    assert main(["listen", "--is-on", "--config", str(file)]) == 0
    assert load(file, OnboardConfig).bus.keys == tmp_path / "keys"


def test_a_process_without_anything_to_say_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["listen", "--config", str(config(tmp_path, ""))]) == 2
    assert capsys.readouterr().err.startswith("ods listen: bus.listen: missing: set `at` (address)")
    assert main(["listen", "--config", str(config(tmp_path, f'keys = "keys"\n{LISTEN}'))]) == 2
    server = tmp_path / "keys" / "server.secret"
    wanted = f"ods listen: bus.keys: {server}: No such file or directory (`ods keys make` makes keys)\n"
    assert capsys.readouterr().err == wanted
    file = config(tmp_path, "")
    assert main(["keys", "list", "--config", str(file)]) == 2
    assert capsys.readouterr().err.startswith(f"ods keys: {file}: bus.keys: missing: name a folder for the keys")


def test_a_client_that_is_used_wrongly_says_so(tmp_path: Path) -> None:
    with pytest.raises(
        RemoteError, match=r"^tcp://127\.0\.0\.1:5600: needs a key: the file that `ods keys make` wrote"
    ):
        Obstacles("tcp://127.0.0.1:5600")
    secret = KeyFolder(tmp_path / "keys").make("planner")
    with pytest.raises(RemoteError, match=r"^tcp://127\.0\.0\.1: invalid argument$"):
        Obstacles("tcp://127.0.0.1", key=secret)
    with pytest.raises(KeyFileError, match=r"server\.secret: server: expected a key of 40 characters$"):
        Obstacles("tcp://127.0.0.1:5600", key=tmp_path / "keys" / "server.secret")
    secret.write_text("not a file of keys")
    with pytest.raises(KeyFileError, match=r"planner\.secret: not a key file: "):
        Obstacles("tcp://127.0.0.1:5600", key=secret)
