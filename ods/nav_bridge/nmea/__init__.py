"""A navigation system that speaks NMEA 0183, and a Doppler log's PD6, on a serial line or by UDP."""
