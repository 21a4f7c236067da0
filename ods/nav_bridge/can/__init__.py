"""The CAN interface: links, frames, buses, time stamps."""
