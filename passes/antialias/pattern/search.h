// SPDX-License-Identifier: BSD-3-Clause
// passes/antialias/pattern/search.h - moves of a device's samples that together see straight edges
// well (not installed).
#ifndef WEFT_PASSES_ANTIALIAS_PATTERN_SEARCH_H
#define WEFT_PASSES_ANTIALIAS_PATTERN_SEARCH_H

#include "passes/antialias/pattern/pattern.h"

WEFT_BEGIN_DECLS

// Moves are so many parts of a pixel, which is what GL places vertices to: moves keep their
// fractions.
enum { WEFT_PATTERN_PARTS = 256 };

// What moves make of a device's samples: the places in the pixel that each comes to lie in.
void weft_pattern_place(const double (*device)[2], int device_count, int passes,
                        const uint8_t (*moves)[2], struct weft_pattern *out);

// What is looked for, and how long: the time grows with tries times samples squared.
struct weft_pattern_search {
    const double (*device)[2];
    int device_count, passes; // more than one pass
    int starts, tries;        // of how many sets, and with how many moves of each
};

// Finds the moves of the least discrepancy, always the same ones, and returns that.
double weft_pattern_search(const struct weft_pattern_search *params, uint8_t (*moves)[2]);

WEFT_END_DECLS
#endif
