"""Obstacle lists to planners and displays of others, over UDP: JSON, NMEA TTM, MOOS-IvP, MAVLink; each bridge is a process."""
