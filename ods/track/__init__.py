"""Obstacles of recorded or simulated pings: files, pictures, movies, scores."""
