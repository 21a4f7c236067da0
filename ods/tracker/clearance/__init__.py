"""Clearance: the water around the vehicle that was observed to be empty, by bearing sector."""
