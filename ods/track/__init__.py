"""`ods track`: obstacles of recorded or simulated pings, as on board: files, pictures, movies, scores."""
