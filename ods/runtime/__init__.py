"""Bus, life of a process, process table, supervisor."""
