"""The mean echo of the sea-bed, flat or rough."""
