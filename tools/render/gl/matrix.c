// SPDX-License-Identifier: BSD-3-Clause
#include "tools/render/gl/matrix.h"

bool scene_extent_seen(const struct scene_extent *extent, const double clip[16])
{
    int outside[5] = {0};
    for (int corner = 0; corner < 8; corner++) {
        double p[4];
        for (int row = 0; row < 4; row++) {
            p[row] = clip[12 + row];
            for (int axis = 0; axis < 3; axis++)
                p[row] += clip[4 * axis + row] *
                          (corner >> axis & 1 ? extent->high[axis] : extent->low[axis]);
        }
        for (int side = 0; side < 4; side++)
            outside[side] += (side & 1 ? p[side / 2] : -p[side / 2]) > p[3];
        outside[4] += p[3] <= 0.0;
    }
    for (int side = 0; side < 5; side++)
        if (outside[side] == 8)
            return false;
    return true;
}

void scene_round(const double *from, float *to, int count)
{
    for (int i = 0; i < count; i++)
        to[i] = (float)from[i];
}
