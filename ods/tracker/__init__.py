"""Detections and poses to obstacles."""
