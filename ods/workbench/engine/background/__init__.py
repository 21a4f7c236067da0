"""Background work: in a separate process, for the newest request only, with listeners."""
