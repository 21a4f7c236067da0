"""How good and how fast detection is: settings, figures of merit, chart."""
