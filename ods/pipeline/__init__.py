"""Pings to detections, by replaceable stages."""
