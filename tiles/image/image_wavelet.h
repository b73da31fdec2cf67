// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/image_wavelet.h - the wavelet of PIZ (not installed).
// Haar's, in integers: of two neighbours there remain their mean and their difference, along lines
// and columns, and then likewise of the means, as long as both sides have two. They stay in the
// places of the neighbours.
#ifndef WEFT_TILES_IMAGE_IMAGE_WAVELET_H
#define WEFT_TILES_IMAGE_IMAGE_WAVELET_H

#include "filter/base.h"

WEFT_BEGIN_DECLS

// Values of 1 or 2 words side by side, tightly packed; words are images of their own.
struct weft_word_image {
    uint16_t *words;
    size_t width, height; // in values
    int size;             // words of a value
    bool small;           // all words were below 2^14: no modulo is needed
};

void weft_wavelet_split(const struct weft_word_image *image);

// Undoes it.
void weft_wavelet_join(const struct weft_word_image *image);

WEFT_END_DECLS
#endif
