"""The small commands of `ods`, one file each."""
