// SPDX-License-Identifier: BSD-3-Clause
#include <stdio.h>

#include <weft.h>

int main(void)
{
    float plane[2] = {0.0f, 1.0f};
    struct weft_preview_params params = {
        .path = "/dev/null", .width = 2, .height = 1, .plane = plane, .low = NAN, .high = NAN};
    printf("weft %s, the first of its kernels: %s\n", weft_version(), weft_kernel_list[0]->name);
    return weft_preview_save(&params, NULL) == WEFT_OK ? 0 : 1;
}
