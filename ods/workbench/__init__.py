"""The workbench [SSIE]: parameters, chain, picture, and the file that runs on board, in one loop, in a browser."""
