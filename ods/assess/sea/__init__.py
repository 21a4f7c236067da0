"""`ods assess sea`: chain and tracker over a family of sea-beds."""
