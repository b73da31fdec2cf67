// SPDX-License-Identifier: BSD-3-Clause
// tests/support/data.h - volumes of the data folder, which may be absent.
#ifndef WEFT_TESTS_SUPPORT_DATA_H
#define WEFT_TESTS_SUPPORT_DATA_H

#include <stdio.h>
#include <unistd.h>

#include "tests/support/common.h"
#include "weft.h"

// The first float grid of a file there; NULL after a line that says that it is not here.
static inline weft_volume *open_data_volume(const char *name)
{
    char path[512];
    weft_volume *volume = NULL;
    snprintf(path, sizeof path, "%s/%s", WEFT_TEST_DATA, name);
    if (access(path, R_OK) != 0) {
        print_message("[  SKIPPED ] %s is not here\n", path);
        return NULL;
    }
    assert_int_equal(weft_volume_open(&(struct weft_volume_open_params){.path = path}, &volume),
                     WEFT_OK);
    return volume;
}

#endif
