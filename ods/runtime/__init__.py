"""What makes a process of a worker: bus, life, process table, supervisor."""
