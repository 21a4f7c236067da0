"""Parts of the simulator's menu: tools, panels, tables, curves, and opening and saving a scene."""
