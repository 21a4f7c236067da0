"""The Blue Robotics Ping360, a mechanically scanned sonar: its messages, beams and sectors, behind `SonarProtocol`."""
