// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/image/plane.h"

const char *const weft_plane_type_names[] = {"float", "half", "unorm8", "unorm16", "uint", NULL};

size_t weft_plane_type_size(enum weft_plane_type type)
{
    static const size_t sizes[] = {4, 2, 1, 2, 4};
    return (unsigned)type < WEFT_PLANE_TYPE_COUNT ? sizes[type] : 0;
}
