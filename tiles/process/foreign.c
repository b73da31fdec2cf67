// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/process/foreign.h"

#include <string.h>

#include "filter/check.h"

// Longer beginnings stand before shorter ones that they start with.
static const struct {
    unsigned char size, bytes[8];
    const char *name;
} kinds[] = {
    {4, {0x20, 'B', 'D', 'V'}, "a VDB volume"},
    {4, {'N', 'R', 'R', 'D'}, "an NRRD volume"},
    {4, {0x76, 0x2f, 0x31, 0x01}, "an EXR image"},
    {8, {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, "a PNG image"},
    {4, {'I', 'I', 42, 0}, "a TIFF image"},
    {4, {'M', 'M', 0, 42}, "a TIFF image"},
    {4, {'I', 'I', 43, 0}, "a TIFF image"},
    {4, {'M', 'M', 0, 43}, "a TIFF image"},
    {3, {0xff, 0xd8, 0xff}, "a JPEG image"},
    {4, {'G', 'I', 'F', '8'}, "a GIF image"},
    {4, {'R', 'I', 'F', 'F'}, "a RIFF file (WebP, AVI or WAV)"},
    {8, {'#', '?', 'R', 'A', 'D', 'I', 'A', 'N'}, "a Radiance HDR image"},
    {4, {0x89, 'H', 'D', 'F'}, "an HDF5 file"},
    {3, {'C', 'D', 'F'}, "a NetCDF file"},
    {5, {'#', ' ', 'v', 't', 'k'}, "a VTK file"},
    {5, {'<', '?', 'x', 'm', 'l'}, "an XML file"},
    {8, {'O', 'b', 'j', 'e', 'c', 't', 'T', 'y'}, "a MetaImage header"},
    {6, {0x93, 'N', 'U', 'M', 'P', 'Y'}, "a NumPy array"},
    {4, {'P', 'K', 3, 4}, "a ZIP archive"},
    {2, {0x1f, 0x8b}, "packed by gzip"},
    {6, {0xfd, '7', 'z', 'X', 'Z', 0}, "packed by xz"},
    {4, {0x28, 0xb5, 0x2f, 0xfd}, "packed by zstd"},
};

const char *weft_foreign_name(const unsigned char *start, size_t size)
{
    for (size_t i = 0; i < WEFT_COUNT(kinds); i++)
        if (size >= kinds[i].size && memcmp(start, kinds[i].bytes, kinds[i].size) == 0)
            return kinds[i].name;
    return NULL;
}
