"""`ods replay`: recordings played again. Never imported on board."""
