"""`make install` on a real Debian with a real systemd, booted in User-mode Linux: `make test-systemd`."""
