"""Missing samples: samples without data, samples below the sonar's threshold, and values to fill them."""
