"""Obstacle lists to planners and displays of others, over UDP, each bridge a process: JSON, TTM, MOOS-IvP, MAVLink."""
