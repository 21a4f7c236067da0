"""The gallery: its exhibits, and pictures and figures of them, made once."""
