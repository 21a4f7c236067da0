"""One ping: what the stages make of it, how it is looked at, compared and judged."""
