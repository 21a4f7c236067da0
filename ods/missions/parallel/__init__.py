"""Missions on several processes or computers, results in order."""
