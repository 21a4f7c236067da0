"""Pings to detections: pure, replaceable stages chained by name."""
