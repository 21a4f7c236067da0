"""Foundation of all packages: units, frames, clocks, settings. Imports nothing else of `ods`."""
