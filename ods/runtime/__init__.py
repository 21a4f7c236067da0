"""What makes a process of a worker: bus, life of a process, process table, supervisor."""
