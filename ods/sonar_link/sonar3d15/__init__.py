"""The Water Linked Sonar 3D-15: its packets, range images and settings, behind `SonarProtocol`."""
