"""Views in the page: images, plans, curves and the timeline, each in Python and in the browser."""
