"""Missions in the loop: their CPU time, and by drawn detections beside images."""
