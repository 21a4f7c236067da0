"""Where nothing is, as far as it was looked at: the water around the vehicle by bearing sector."""
