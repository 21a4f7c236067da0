"""Life cycle of objects, scan by scan: judged, confirmed, hibernated, activated, terminated."""
