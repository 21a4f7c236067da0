"""What everything rests on: units, frames, clocks, settings, compilation. Imports nothing else of `ods`."""
