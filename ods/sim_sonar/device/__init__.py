"""The live devices of the bench: the sonar on its line, the INS on its CAN bus."""
