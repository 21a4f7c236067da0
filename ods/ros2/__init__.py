"""Messages of ROS 2, made without ROS: frames (ENU, FLU), types, what obstacles, water and images become."""
