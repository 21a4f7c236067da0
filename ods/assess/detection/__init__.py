"""Quality and speed of detection: settings, figures of merit, chart."""
