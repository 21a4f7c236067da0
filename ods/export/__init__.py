"""`ods export`: a recording in the formats of other people's tools. Never imported on board."""
