"""Files, charts and tables of simulated images."""
