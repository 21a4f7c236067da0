"""The Blueprint Subsea Oculus M series: its messages, images and settings, behind `SonarProtocol`."""
