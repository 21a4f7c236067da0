"""Way of a steered vehicle: judged, beside the best way, drawn."""
