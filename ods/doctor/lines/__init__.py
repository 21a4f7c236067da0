"""The lines to sonar and navigation source: CAN interfaces, serial devices, network ports."""
