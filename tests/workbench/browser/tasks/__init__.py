"""What an engineer does with the workbench, from the first page on, by as many clicks as the docs say."""
