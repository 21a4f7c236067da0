"""What a ping observes: the field of view, echoes that its edge cuts off, and ranges that objects hide."""
