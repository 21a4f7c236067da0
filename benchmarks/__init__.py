"""Development only: what guards the figures of the docs, by subject. Nothing on board imports this."""
