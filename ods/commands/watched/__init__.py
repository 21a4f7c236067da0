"""What `ods watch` shows: what processes say, as JSON or as a table in the terminal."""
