/* Cells of the water around the vehicle: how far they are from what is not known. */

#include "kernel.h"

/* By how many steps to a neighbour each cell is away from one that is not in the mask, or from the rim: one pass from
   each of two opposite corners. */
KERNEL(cells_from_others, "b1[rows,columns] mask, out u2[rows,columns] away")
{
    const bool *mask = ARRAY(bool, 0);
    uint16_t *away = ARRAY(uint16_t, 1);
    const int64_t rows = SIZE(0, 0), columns = SIZE(0, 1);
    for (int64_t i = 0, k = 0; i < rows; i++)
        for (int64_t j = 0; j < columns; j++, k++) {
            const int up = i > 0 ? away[k - columns] : 0, left = j > 0 ? away[k - 1] : 0;
            away[k] = (uint16_t)(mask[k] ? 1 + (up < left ? up : left) : 0);
        }
    for (int64_t i = rows - 1, k = rows * columns - 1; i >= 0; i--)
        for (int64_t j = columns - 1; j >= 0; j--, k--) {
            const int down = i < rows - 1 ? away[k + columns] : 0, right = j < columns - 1 ? away[k + 1] : 0;
            const int nearer = 1 + (down < right ? down : right);
            if (nearer < away[k])
                away[k] = (uint16_t)nearer;
        }
}
