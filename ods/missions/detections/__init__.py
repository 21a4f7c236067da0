"""Detections without images: laws of what the pipeline makes of bodies, fitted to images, and draws by them."""
