// SPDX-License-Identifier: BSD-3-Clause
#include "passes/hardware/plan.h"

size_t weft_hardware_atlas_blocks(const struct weft_hardware_atlas *atlas)
{
    return (size_t)atlas->blocks[0] * (size_t)atlas->blocks[1] * (size_t)atlas->blocks[2];
}

bool weft_hardware_atlas_fit(size_t count, int side, int max_size, struct weft_hardware_atlas *out)
{
    *out = (struct weft_hardware_atlas){.side = side, .size = {1, 1, 1}};
    while (weft_hardware_atlas_blocks(out) < count) {
        int smallest = 0;
        for (int a = 1; a < 3; a++)
            if (out->size[a] < out->size[smallest])
                smallest = a;
        if (2 * out->size[smallest] > max_size)
            return false;
        out->size[smallest] *= 2;
        for (int a = 0; a < 3; a++)
            out->blocks[a] = out->size[a] / side;
    }
    return true;
}

uint64_t weft_hardware_atlas_bytes(const struct weft_hardware_atlas *atlas,
                                   enum weft_source_format format)
{
    return (uint64_t)weft_source_format_bytes(format) * (uint64_t)atlas->size[0] *
           (uint64_t)atlas->size[1] * (uint64_t)atlas->size[2];
}
