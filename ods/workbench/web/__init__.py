"""The workbench's server: who may speak to it, images to the browser, the fan view."""
