"""Missing samples: which hold no data, which the sonar left out, and the values that stand for them."""
