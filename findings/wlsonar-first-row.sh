#!/bin/sh
# The first row of a Sonar 3D-15 range image, as wlsonar and its manual have it, is the lowest one.
#
# Version:   wlsonar 0.5.5; compared: Water Linked's description of the protocol (Sonar 3D-15 integration API)
# Behaviour: range_image_to_xyz() gives row 0 the pitch -fov/2 and z = -r sin(pitch); z points down by the manual.
# Seen:      64 rows over 40 degrees, 10 m: row 0 at z = +3.42 m (below), row 63 at z = -3.42 m (above); column 0 at
#            y < 0 (port)
# Expected:  row 0 on top, as arrays are drawn as images by default, the more as columns run from left to right.
# Matters:   who takes the array for an image swaps what is above the vehicle and what is below it: 6.8 m in height at
#            the edges of the field of view, 10 m away.
set -eu
place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
python3 -m venv "$place/venv"
"$place/venv/bin/pip" install --quiet --disable-pip-version-check wlsonar==0.5.5
"$place/venv/bin/python" - <<'END'
import sys

import wlsonar
from wlsonar.range_image_protocol import RangeImage

WIDTH, HEIGHT = 256, 64
image = RangeImage(
    width=WIDTH, height=HEIGHT, fov_horizontal=90.0, fov_vertical=40.0, image_pixel_scale=0.01,
    image_pixel_data=WIDTH * HEIGHT * [1000],
)
points = wlsonar.range_image_to_xyz(image)
first, last = points[0], points[-1]
seen = (round(first[2], 2), round(last[2], 2), first[1] < 0.0 < last[1])
if seen != (3.42, -3.42, True):
    sys.exit(f"changed: z of the first and of the last row, columns from port to starboard: {seen}")
print(f"as before: z of the first and of the last row, columns from port to starboard: {seen}")
END
