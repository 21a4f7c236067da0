"""Does an echo over a rough bed set in as a body does? Judged by the recorded samples around it."""
