"""A stock ROS 2 node: `PYTHON ros2_node.py`, by a Python that has rclpy and nothing of ODS; prints what it receives.

A JSON object a line: of each message its topic and stamp, and of each topic, once, the hashes of both ends' types.
"""

import json
from typing import Any

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from nav_msgs.msg import Odometry
from sensor_msgs.msg import PointCloud2
from visualization_msgs.msg import MarkerArray

TOPICS = {
    "/ods/markers": MarkerArray, "/ods/clearance": PointCloud2, "/ods/odometry": Odometry,
    "/diagnostics": DiagnosticArray,
}  # fmt: skip


def main() -> None:
    """Listen until killed."""
    rclpy.init()
    node = rclpy.create_node("planner")
    hashed = set()

    def receive(topic: str, message: Any) -> None:
        header = message.markers[0].header if topic == "/ods/markers" else message.header
        reported = {
            "topic": topic,
            "frame": header.frame_id,
            "stamp_ns": header.stamp.sec * 10**9 + header.stamp.nanosec,
        }
        if topic == "/ods/markers":
            reported["enu"] = [[m.pose.position.x, m.pose.position.y, m.pose.position.z] for m in message.markers[1:]]
        if topic == "/ods/clearance":
            reported["points"] = message.width
        if topic == "/diagnostics":
            reported["level"] = message.status[0].level[0]
        print(json.dumps(reported), flush=True)
        if topic not in hashed:
            hashed.add(topic)
            theirs = [str(each.topic_type_hash) for each in node.get_publishers_info_by_topic(topic)]
            own = [str(each.topic_type_hash) for each in node.get_subscriptions_info_by_topic(topic)]
            print(json.dumps({"topic": "hashes", "of": topic, "theirs": theirs, "own": own}), flush=True)

    for topic, kind in TOPICS.items():
        node.create_subscription(kind, topic, lambda message, topic=topic: receive(topic, message), 10)
    print(json.dumps({"ready": True}), flush=True)
    rclpy.spin(node)


main()
