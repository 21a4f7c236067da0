"""`ods doctor`: checks configuration, devices, sockets, clock and versions, and says in plain words what is wrong."""
