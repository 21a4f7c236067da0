"""Output of `ods watch`: what processes report, as JSON or as a table in the terminal."""
