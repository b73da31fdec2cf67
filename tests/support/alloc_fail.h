// SPDX-License-Identifier: BSD-3-Clause
// tests/support/alloc_fail.h - makes the k-th allocation fail. The test binary is linked to the static
// libraries with --wrap for malloc, calloc, realloc, aligned_alloc, strdup and asprintf (see
// CMakeLists.txt), so it sees what weft allocates, and what OpenEXRCore and libpng ask weft for.
#ifndef WEFT_TESTS_SUPPORT_ALLOC_FAIL_H
#define WEFT_TESTS_SUPPORT_ALLOC_FAIL_H

#include <stdbool.h>

// The k-th allocation from now on fails, and only that one; 0 disarms. Not for several threads.
void alloc_fail_at(unsigned long k);

// Whether it has happened since.
bool alloc_fail_struck(void);

#endif
