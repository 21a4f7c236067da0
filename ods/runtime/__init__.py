"""Parts that make a process of a worker: bus, life of a process, process table, supervisor."""
