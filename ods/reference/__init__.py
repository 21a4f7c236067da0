"""The generated pages of docs/: messages, configuration, counters, from the types and tables of the code."""
