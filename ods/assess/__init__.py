"""How good and how fast detection and tracking are. Never imported on board."""
