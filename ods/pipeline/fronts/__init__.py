"""Does a faint echo set in as a body does? Judged by the recorded samples around it."""
