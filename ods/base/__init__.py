"""Units, frames, clocks, settings; imports nothing else of `ods`."""
