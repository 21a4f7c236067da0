"""Ways to make levels follow the background, beside one another: accuracy against time."""
