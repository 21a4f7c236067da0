"""The gallery: its demos, and pictures and figures of them, made once."""
