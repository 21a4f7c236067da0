"""What the pages of the workbench let compute: no widgets."""
