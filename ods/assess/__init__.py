"""Quality and speed of detection and tracking."""
