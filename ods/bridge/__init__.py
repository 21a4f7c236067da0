"""Obstacle lists to other planners and displays, each bridge a process."""
