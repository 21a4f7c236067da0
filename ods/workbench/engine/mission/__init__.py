"""A whole mission: tracked again, what is known of its pings and objects, marks on its timeline."""
