"""ODS: an obstacle detection service for autonomous underwater vehicles."""

__version__ = "0.6.0"
