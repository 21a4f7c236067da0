"""Images of which it is known what they show: simulated, drawn, and labelled by eye."""
