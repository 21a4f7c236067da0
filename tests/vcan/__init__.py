"""Tests that need a real SocketCAN vcan0 and vcan1: `make test-vcan` has them by in_vcan."""
