"""Runs a command where real SocketCAN interfaces vcan0 and vcan1 exist. Standard library only, Linux only."""
