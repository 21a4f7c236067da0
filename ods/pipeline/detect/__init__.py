"""Stages `detect.*`: from an image to the regions that stand out."""
