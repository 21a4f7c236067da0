"""The tracker: CPU time of a scan step, and whether its tracks are as good as they claim."""
