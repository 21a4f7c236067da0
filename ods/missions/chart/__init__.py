"""`ods missions --chart`: how many collisions a millisecond buys."""
