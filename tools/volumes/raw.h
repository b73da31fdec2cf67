// SPDX-License-Identifier: BSD-3-Clause
// tools/volumes/raw.h - the option --raw, the layout of volumes without a header, for all verbs
// that take a volume.
#ifndef WEFT_TOOLS_VOLUMES_RAW_H
#define WEFT_TOOLS_VOLUMES_RAW_H

#include "tools/options/options.h"

// An entry of a verb's table.
#define RAW_OPTION                                                                                 \
    {                                                                                              \
        .name = "raw", 0, OPTION_TEXT, "LAYOUT",                                                   \
        "the volume is samples without a header: NXxNYxNZ:TYPE[:little|big][:skip=BYTES]"          \
        "[:spacing=X,Y,Z][:origin=X,Y,Z], where TYPE is uint8, int8, uint16, int16, uint32, "      \
        "int32, uint64, int64, float or double; x is stored fastest; little, no bytes, spacing 1 " \
        "and origin 0 where nothing is said",                                                      \
        .group = OPTION_FILES                   \
    }

// Parses a value. *raw is `out`, or NULL where the option is not given. Returns WEFT_ERR_ARGUMENT
// after one error line.
enum weft_result raw_read(const struct option_value *value, struct weft_raw_layout *out,
                          const struct weft_raw_layout **raw);

#endif
