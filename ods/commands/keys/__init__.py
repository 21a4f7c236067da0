"""The actions of `ods keys`, one file each."""
