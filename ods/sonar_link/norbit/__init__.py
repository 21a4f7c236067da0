"""The Norbit WBMS as a forward-looking sonar: its packets, images, commands and settings, behind `SonarProtocol`."""
