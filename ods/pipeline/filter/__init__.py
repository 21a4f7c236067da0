"""Stages `filter.*`: against noise and speckle."""
