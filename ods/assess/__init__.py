"""How good and how fast detection is: labelled images, metrics, chart. Never imported on board."""
