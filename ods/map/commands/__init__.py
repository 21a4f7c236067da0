"""The actions of `ods map`, one file each. Reading works while a tracker runs."""
