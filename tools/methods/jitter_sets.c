// SPDX-License-Identifier: BSD-3-Clause
#include "tools/methods/jitter_sets.h"

#include <stdio.h>

#include "weft.h"

void jitter_sets_print(void)
{
    puts("sets:");
    for (int i = 0; weft_jitter_list[i]; i++)
        printf("  %-12s %s\n", weft_jitter_list[i]->name, weft_jitter_list[i]->description);
}
