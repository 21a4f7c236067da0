"""Recordings in other tools' formats."""
