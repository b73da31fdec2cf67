// SPDX-License-Identifier: BSD-3-Clause
// Text that comes from outside; the readers use it too.
#include "filter/base.h"

#include <string.h>

// The bytes of the UTF-8 sequence at `text`, and its code point; 0 if it is none.
static size_t decode_utf8(const char *text, uint32_t *point)
{
    static const uint32_t smallest[] = {0, 0, 0x80, 0x800, 0x10000};
    const unsigned char *c = (const unsigned char *)text;
    size_t length = *c < 0x80 ? 1 : *c >> 5 == 6 ? 2 : *c >> 4 == 14 ? 3 : *c >> 3 == 30 ? 4 : 0;
    *point = length < 2 ? *c : *c & (0x7fu >> length);
    for (size_t i = 1; i < length; i++) {
        if (c[i] >> 6 != 2) // the end of the text, too
            return 0;
        *point = *point << 6 | (c[i] & 0x3f);
    }
    bool surrogate = *point >= 0xd800 && *point <= 0xdfff;
    return *point < smallest[length] || *point > 0x10ffff || surrogate ? 0 : length;
}

static bool printable(uint32_t point, bool keep_lines)
{
    if (point < 0x20)
        return keep_lines && (point == '\n' || point == '\t');
    bool turns = point == 0x61c || point == 0x200e || point == 0x200f ||
                 (point >= 0x2028 && point <= 0x202e) || (point >= 0x2066 && point <= 0x2069);
    return !turns && (point < 0x7f || point > 0x9f);
}

char *weft_text_clean(char *text, bool keep_lines)
{
    char *out = text;
    for (const char *in = text; *in;) {
        uint32_t point;
        size_t length = decode_utf8(in, &point);
        if (length && printable(point, keep_lines)) {
            memmove(out, in, length);
            out += length;
        } else {
            *out++ = '?';
        }
        in += length ? length : 1;
    }
    *out = 0;
    return text;
}

const char *weft_text_skip_mark(const char *text)
{
    static const char mark[] = "\xef\xbb\xbf";
    return strncmp(text, mark, strlen(mark)) == 0 ? text + strlen(mark) : text;
}
