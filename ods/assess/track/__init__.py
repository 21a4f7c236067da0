"""`ods assess track`: trackers on a fixed set of scenarios, beside one that knows the answers and a library."""
