"""Stages `equalize.*`: the same background level everywhere."""
