"""How a steered vehicle came through: judged, beside the best way, drawn."""
