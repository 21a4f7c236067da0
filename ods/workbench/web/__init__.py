"""The workbench's server: who may speak to it, images to the browser, its views and charts."""
