"""What everything rests on: units, frames, clocks, settings. Imports nothing else of `ods`."""
