// SPDX-License-Identifier: BSD-3-Clause
// tools/common/attributes.h - what an EXR file that weft writes says about itself.
#ifndef WEFT_TOOLS_COMMON_ATTRIBUTES_H
#define WEFT_TOOLS_COMMON_ATTRIBUTES_H

#include "weft.h"

// The texts as attributes of type string, which point to them.
void attributes_of_texts(const struct weft_metadata *texts, size_t count,
                         struct weft_image_attribute *out);

// An input's attributes for a result of other pixels; scale: result pixels per input pixel, along x
// and y. Drops those of an earlier weft, and corrects what the scale changes: pixelAspectRatio, and
// xDensity. Values that are corrected are put into numbers[2], which the result points to.
// Returns how many; out has room for all of the input's and one more.
size_t attributes_scaled(const struct weft_image *image, const double scale[2],
                         struct weft_image_attribute *out, unsigned char numbers[2][4]);

#endif
