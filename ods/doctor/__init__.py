"""Checks of configuration, devices, sockets, clock and versions."""
