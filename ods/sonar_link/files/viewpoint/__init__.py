"""Logs of Oculus ViewPoint (.oculus): items in a row, and the SQLite database of ViewPoint 2."""
