// SPDX-License-Identifier: BSD-3-Clause
// What files are, and how they store samples; reader programs use it, too.
#include <string.h>

#include "tiles/volume/volume.h"

const char *const weft_volume_format_names[WEFT_VOLUME_FORMAT_COUNT + 1] = {"memory", "vdb", "nrrd",
                                                                            "nifti", "raw"};
const char *const weft_sample_type_names[WEFT_SAMPLE_TYPE_COUNT + 1] = {
    "uint8", "int8", "uint16", "int16", "uint32", "int32", "uint64", "int64", "float", "double"};
const size_t weft_sample_sizes[WEFT_SAMPLE_TYPE_COUNT] = {1, 1, 2, 2, 4, 4, 8, 8, 4, 8};

// It begins with the size of its header, 348 or 540, in either byte order (nifti1.h, nifti2.h).
static bool is_nifti(const unsigned char *start)
{
    static const unsigned char first[2][4] = {{0x5c, 1, 0, 0}, {0, 0, 1, 0x5c}},
                               second[2][4] = {{0x1c, 2, 0, 0}, {0, 0, 2, 0x1c}},
                               gzip[2] = {0x1f, 0x8b};
    if (!memcmp(start, gzip, sizeof gzip))
        return true;
    for (int order = 0; order < 2; order++)
        if (!memcmp(start, first[order], 4) || !memcmp(start, second[order], 4))
            return true;
    return false;
}

enum weft_volume_format weft_volume_recognise(const void *start, size_t size)
{
    if (size >= 4 && !memcmp(start, " BDV", 4))
        return WEFT_VOLUME_VDB;
    if (size >= 4 && !memcmp(start, "NRRD", 4))
        return WEFT_VOLUME_NRRD;
    return size >= 4 && is_nifti(start) ? WEFT_VOLUME_NIFTI : WEFT_VOLUME_MEMORY;
}
