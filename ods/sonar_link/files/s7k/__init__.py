"""The .s7k file format: recordings read, written and repaired. Its records are those of the wire, and a few more."""
