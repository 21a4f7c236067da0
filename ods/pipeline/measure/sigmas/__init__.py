"""Standard deviations of circles, and the features and laws that they follow from."""
