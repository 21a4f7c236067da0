"""Messages of ROS 2, made without ROS."""
