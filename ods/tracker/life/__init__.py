"""The life of objects, scan by scan: judged, confirmed, put to sleep in the map, woken, ended."""
