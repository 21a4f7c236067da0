"""Work beside the page: in a process of its own, the newest request only, and who receives of it."""
