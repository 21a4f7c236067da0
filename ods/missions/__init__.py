"""`ods missions`: many missions in random worlds, with the vehicle in the loop, and what came of them."""
