"""The simulator: its error budget, its images beside real ones, scenes drawn at random."""
