"""A range image of a 3-D sonar to detections with heights: bottom, clusters, circles, how far the water is clear."""
