"""Work beside the page: in a process of its own, the newest request only, and who is informed of it."""
