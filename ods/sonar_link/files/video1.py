"""Microsoft Video 1 with 8 bits a pixel (`CRAM`, `MSVC`): what DIDSON's own software writes into .avi clips.

An image is blocks of 4 x 4 pixels, row by row from the bottom left; so are the pixels of a block. Two bytes say how a
block is coded; blocks that are skipped keep what the frame before showed. Source: the public description of the codec,
"Microsoft Video 1", at wiki.multimedia.cx.
"""

import numpy as np

from ods.base.arrays import Bytes

Pixels = Bytes

_SKIP, _SKIP_MASK = 0x84, 0xFC
_TWO_COLOURS_BELOW, _EIGHT_COLOURS_FROM = 0x80, 0x90
_BITS = np.arange(16).reshape(4, 4)
_QUADRANT = 2 * (np.array([0, 0, 2, 2])[:, None] + np.array([0, 0, 1, 1])[None, :])
"""(4, 4) first of the two colours of each pixel when a block has eight: two for each quarter of it."""


def decode(data: bytes, image: Pixels) -> None:
    """Bring image (rows, columns), colour numbers, row 0 the top one, from the frame before to this one.

    Sides that are no multiples of 4 lose the rest. Raises ValueError for data that end within a block.
    """
    across, blocks = image.shape[1] // 4, (image.shape[0] // 4) * (image.shape[1] // 4)
    upwards = image[::-1]
    place, block = 0, 0
    while block < blocks:
        if place + 2 > len(data):
            raise ValueError("the image data end early")
        low, high = data[place], data[place + 1]
        place += 2
        if low == high == 0:
            return
        if high & _SKIP_MASK == _SKIP:
            block += ((high - _SKIP) << 8) + low
            continue
        row, column = 4 * (block // across), 4 * (block % across)
        block += 1
        target = upwards[row : row + 4, column : column + 4]
        if _TWO_COLOURS_BELOW <= high < _EIGHT_COLOURS_FROM:
            target[:] = low
            continue
        wanted = 2 if high < _TWO_COLOURS_BELOW else 8
        colours = np.frombuffer(data[place : place + wanted], np.uint8)
        if colours.size < wanted:
            raise ValueError("the image data end early")
        place += wanted
        second = 1 - ((((high << 8) | low) >> _BITS) & 1)
        target[:] = colours[second if wanted == 2 else _QUADRANT + second]
