"""Bad configuration of the bridge to ROS 2 is one line that names the key; DDS is bound to one interface."""

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from ods.base.settings_file import ConfigError, load
from ods.bridge.ros2.interface import address_of, configuration
from ods.bridge.ros2.topics import TOPICS, wanted
from ods.bridge.settings import Ros2Settings
from ods.config import OnboardConfig
from tests.bridge.test_settings import config


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        ('interface = "eth0"', "peers: name the nodes' computers on eth0, or set multicast = true"),
        ('interface = "eth0"\npeers = ["robot"]', 'peers: robot: needs an IP address, such as "192.168.2.5"'),
        ('peers = ["239.255.0.1"]', "peers: 239.255.0.1: must be one computer"),
        ('peers = ["0.0.0.0"]', "peers: 0.0.0.0: must be one computer"),
        ('peers = ["255.255.255.255"]', "peers: 255.255.255.255: must be one computer"),
        ("interface = \"lo'/><x y='\"", "bridge.ros2.interface: "),
        ("domain = 233", "bridge.ros2.domain: "),
        ('namespace = "ods"', "bridge.ros2.namespace: "),
        ('map_frame = "/map"', "bridge.ros2.map_frame: "),
        ('send = ["lidar"]', "bridge.ros2.send"),
        ("send = []", "bridge.ros2.send: "),
        ("most_hz = 0.0", "bridge.ros2.most_hz: "),
        ("image_hz = 0.0", "bridge.ros2.image_hz: "),
        ('to = "udp://127.0.0.1:5"', "bridge.ros2.to: "),
    ],
)
def test_bad_configuration_is_one_line_that_names_the_key(tmp_path: Path, keys: str, said: str) -> None:
    file = config(tmp_path, f"\n[bridge.ros2]\n{keys}\n")
    with pytest.raises(ConfigError) as refused:
        load(file, OnboardConfig)
    text = str(refused.value)
    assert text.startswith(f"{file}: bridge.ros2")
    assert said in text
    assert "\n" not in text


def test_by_default_only_this_computer_hears_it(tmp_path: Path) -> None:
    table = load(config(tmp_path, "\n[bridge.ros2]\n"), OnboardConfig).bridge.ros2
    assert table == Ros2Settings()
    reported = ElementTree.fromstring(configuration(Ros2Settings()))
    assert [each.get("name") for each in reported.iter("NetworkInterface")] == ["lo"]
    assert [each.get("address") for each in reported.iter("Peer")] == ["127.0.0.1"]
    assert [each.text for each in reported.iter("AllowMulticast")] == ["false"]
    assert [each.text for each in reported.iter("IgnoreTypeInformation")] == ["1.15"]


def test_another_interface_has_its_peers_only() -> None:
    reported = ElementTree.fromstring(configuration(Ros2Settings(interface="eth0.7", peers=("192.168.2.5",))))
    assert [each.get("name") for each in reported.iter("NetworkInterface")] == ["eth0.7"]
    assert [each.get("address") for each in reported.iter("Peer")] == ["192.168.2.5"]
    assert [each.text for each in reported.iter("AllowMulticast")] == ["false"]


def test_an_interface_that_is_not_there_is_said() -> None:
    assert address_of("lo") == "127.0.0.1"
    with pytest.raises(OSError, match="there is no such interface"):
        address_of("nowhere0")


def test_names_of_topics() -> None:
    rows = wanted(Ros2Settings(namespace="/auv/sonar", send=("obstacles", "diagnostics", "tf")))
    assert [row.name for row in rows] == ["/auv/sonar/obstacles", "/diagnostics", "/tf"]
    assert len(TOPICS) == len({row.name for row in TOPICS}) == len({row.key for row in TOPICS})


def test_a_missing_extra_is_named(tmp_path: Path) -> None:
    file = config(tmp_path, "\n[bridge.ros2]\n")
    file.write_text(file.read_text().replace("[bus]", f'[bus]\nrun_dir = "{tmp_path}"'))
    program = (
        "import sys; sys.modules['cyclonedds'] = sys.modules['rosbags'] = None; from ods.cli import main; "
        f"sys.exit(main(['bridge', 'ros2', '--config', {str(file)!r}]))"
    )
    ran = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False, timeout=60.0)
    assert (ran.returncode, ran.stderr) == (
        2, "ods bridge: needs pip install 'ods[ros2]': there is no cyclonedds\n",
    )  # fmt: skip
