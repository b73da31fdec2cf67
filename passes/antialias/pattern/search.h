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

// Finds the moves of passes > 1 passes, always the same ones.
void weft_pattern_search(const double (*device)[2], int device_count, int passes,
                         uint8_t (*moves)[2]);

WEFT_END_DECLS
#endif
