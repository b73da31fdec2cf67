// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/transfer.h - what the integer codes of PNG and TIFF files stand for: light from 0 to
// 1, by a curve. Floats and halves are light as they are.
#ifndef WEFT_TILES_IMAGE_TRANSFER_H
#define WEFT_TILES_IMAGE_TRANSFER_H

#include "../../filter/base.h"

WEFT_BEGIN_DECLS

// From code / largest code to light. What is below 0 is as what is above, with its sign.
enum weft_curve {
    WEFT_CURVE_AUTO,   // what the file says, or sRGB (default)
    WEFT_CURVE_LINEAR, // codes are taken as they are
    WEFT_CURVE_SRGB,   // IEC 61966-2-1
    WEFT_CURVE_POWER,  // code ^ exponent
    WEFT_CURVE_COUNT
};
struct weft_transfer {
    enum weft_curve curve;
    double exponent; // of a power, > 0; others ignore it
};

// What a PNG or TIFF file says of its codes. In files palettes and 1, 2 and 4 bits are expanded to
// 8 or 16 (exactly: code * largest / largest), a transparent colour becomes alpha.
struct weft_code_info {
    int bits;        // of a channel, as stored: 1, 2, 4, 8, 16 or 32; of a palette's index
    bool palette;    // it was expanded
    bool alpha;      // the last channel is alpha, stored as such or as a transparent colour
    bool interlaced; // Adam7, of PNG
    bool srgb;       // it says that its colours are sRGB
    bool icc;        // it has an ICC profile, which is not applied
    bool associated; // colours are multiplied by alpha as stored (TIFF; never in PNG)
    double gamma;    // exponent from light to code that it says (sRGB: 0.45455); 0: none
    // Coding-independent code points (ITU-T H.273), which say more than gamma and profile: colour
    // primaries, transfer function, matrix, full range. All 0: none.
    uint8_t cicp[4];
};

// Returns the light of a code, or the code of light; the curve is not AUTO. NaN gives NaN. Pure.
WEFT_API double weft_transfer_light(const struct weft_transfer *transfer, double code);
WEFT_API double weft_transfer_code(const struct weft_transfer *transfer, double light);

// Finds what a file says of its codes: code points first, then sRGB, then gamma, as the PNG
// specification ranks them, and sRGB where it says nothing. Returns false for a transfer function
// of H.273 that is none of 4, 5, 8 and 13 (powers of 2.2 and 2.8, linear, sRGB); *out is then sRGB.
WEFT_API bool weft_transfer_find(const struct weft_code_info *info, struct weft_transfer *out);

WEFT_END_DECLS
#endif
