"""The bridge to ROS 2 by DDS (cyclonedds): a process of its own, and the only part that needs the extra 'ros2'."""
