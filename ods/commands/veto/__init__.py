"""The actions of `ods veto`, one file each."""
