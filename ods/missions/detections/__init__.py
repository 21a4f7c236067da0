"""Detections without images, drawn from distributions that were fitted to the pipeline's detections of objects in
images."""
