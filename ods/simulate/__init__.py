"""`ods simulate`: files, charts and tables of simulated sonar images."""
