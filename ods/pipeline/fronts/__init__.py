"""Leading edges over rough sea-beds: the probability that an echo starts like an object's, from the recorded
samples."""
