#!/bin/sh
# A ROS 2 Kilted node hears nothing of a publisher by cyclonedds, though it lists its topic.
#
# Version:   cyclonedds 11.0.1; ros-rclpy 9.1.2 (ROS 2 Kilted, Fast DDS 3.2.3)
# Behaviour: Cyclone does not match a subscription of Fast DDS 3, whose type information it cannot read.
# Seen:      sensor_msgs/LaserScan over loopback, reliable: the node lists the topic and receives 0 of 20 messages, without an
#            error at the node; with Compatibility/IgnoreTypeInformation = 1.15 (the vendor of Fast DDS) 20 of 20
# Expected:  20 of 20: names of topic and type are the same, and type information is optional (DDS-XTypes 1.3, 7.6.3.4.2:
#            where it cannot be had, types are compared by name).
# Matters:   obstacles that a vehicle's planner never hears of, while its tools show the topic as published.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check cyclonedds==11.0.1 ros-rclpy==9.1.2 ros-rmw-fastrtps-cpp==9.3.3 \
  ros-sensor-msgs==5.5.1
cat >"$place/node.py" <<'END'
import time

import rclpy
from sensor_msgs.msg import LaserScan

rclpy.init()
node, heard = rclpy.create_node("planner"), []
node.create_subscription(LaserScan, "/scan", heard.append, 30)
end = time.monotonic() + 20.0
listed = False
while time.monotonic() < end and len(heard) < 20:
    rclpy.spin_once(node, timeout_sec=0.1)
    listed = listed or any(name == "/scan" for name, _ in node.get_topic_names_and_types() if node.count_publishers(name))
print(len(heard), listed)
END
cat >"$place/writer.py" <<'END'
import sys
import time
from dataclasses import dataclass

from cyclonedds.domain import Domain, DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.types import float32, int32, sequence, uint32
from cyclonedds.pub import DataWriter
from cyclonedds.qos import Policy, Qos
from cyclonedds.topic import Topic
from cyclonedds.util import duration


@dataclass
class Time(IdlStruct, typename="builtin_interfaces.msg.dds_.Time_"):
    sec: int32
    nanosec: uint32


@dataclass
class Header(IdlStruct, typename="std_msgs.msg.dds_.Header_"):
    stamp: Time
    frame_id: str


@dataclass
class LaserScan(IdlStruct, typename="sensor_msgs.msg.dds_.LaserScan_"):
    header: Header
    angle_min: float32
    angle_max: float32
    angle_increment: float32
    time_increment: float32
    scan_time: float32
    range_min: float32
    range_max: float32
    ranges: sequence[float32]
    intensities: sequence[float32]


domain = int(sys.argv[1])
config = (
    "<CycloneDDS><Domain Id='any'><General><Interfaces><NetworkInterface name='lo'/></Interfaces>"
    "<AllowMulticast>false</AllowMulticast></General><Discovery><ParticipantIndex>auto</ParticipantIndex>"
    "<Peers><Peer address='127.0.0.1'/></Peers></Discovery>" + sys.argv[2] + "</Domain></CycloneDDS>"
)
keep = Domain(domain, config)
participant = DomainParticipant(domain)
kept = Qos(Policy.Reliability.Reliable(duration(seconds=1)), Policy.History.KeepLast(30))
writer = DataWriter(participant, Topic(participant, "rt/scan", LaserScan), qos=kept)
end = time.monotonic() + 12.0
while not writer.get_matched_subscriptions() and time.monotonic() < end:
    time.sleep(0.1)
time.sleep(0.5)
for number in range(20):
    writer.write(LaserScan(Header(Time(number, 0), "map"), 0.0, 1.0, 1.0, 0.0, 0.0, 0.0, 9.0, [1.0, 2.0], []))
    time.sleep(0.05)
time.sleep(8.0)
END
export ROS_AUTOMATIC_DISCOVERY_RANGE=LOCALHOST HOME="$place"
heard() {
  ROS_DOMAIN_ID=$1 "$place/venv/bin/python" "$place/node.py" >"$place/heard" 2>/dev/null &
  node=$!
  "$place/venv/bin/python" "$place/writer.py" "$1" "$2" 2>/dev/null
  wait $node
  cat "$place/heard"
}
plain=$(heard 71 "")
cured=$(heard 72 "<Compatibility><IgnoreTypeInformation>1.15</IgnoreTypeInformation></Compatibility>")
echo "plain: $plain; type information ignored: $cured"
[ "$plain" = "0 True" ] && [ "$cured" = "20 True" ]
