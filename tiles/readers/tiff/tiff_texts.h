// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/tiff/tiff_texts.h - texts of TIFF files by the names of EXR's attributes (not
// installed).
#ifndef WEFT_TILES_READERS_TIFF_TIFF_TEXTS_H
#define WEFT_TILES_READERS_TIFF_TIFF_TEXTS_H

#include <stdint.h>

#include <tiff.h>

// A page's name is that of an EXR part.
static const struct {
    uint32_t tag;
    const char *name;
} weft_tiff_texts[] = {
    {TIFFTAG_IMAGEDESCRIPTION, "comments"},
    {TIFFTAG_COPYRIGHT, "owner"},
    {TIFFTAG_ARTIST, "artist"},
    {TIFFTAG_DATETIME, "capDate"},
    {TIFFTAG_MAKE, "cameraMake"},
    {TIFFTAG_MODEL, "cameraModel"},
    {TIFFTAG_DOCUMENTNAME, "DocumentName"},
    {TIFFTAG_PAGENAME, "name"},
};

#endif
