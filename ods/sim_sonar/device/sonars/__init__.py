"""Simulated sonars: what each obeys, and its messages as its maker's sonar writes them."""
