"""Detections and pose to obstacles: observers, association, life cycle, map."""
