"""Quality and speed of detection and tracking. Never imported on board."""
