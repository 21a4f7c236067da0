"""Checks configuration, devices, sockets, clock and versions."""
