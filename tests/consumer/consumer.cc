// SPDX-License-Identifier: BSD-3-Clause
#include <weft.h>

int main()
{
    return weft_kernel_find("catmull-rom") ? 0 : 1;
}
