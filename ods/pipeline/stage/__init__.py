"""What a stage is: its register, its settings, what it is told of each ping."""
