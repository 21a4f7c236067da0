"""The workbench's menus: widgets only; what they do is an action of the session or a computation of the engine."""
