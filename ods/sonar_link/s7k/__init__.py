"""The RESON 7k Data Format, the protocol of SeaBat sonars."""
