// SPDX-License-Identifier: BSD-3-Clause
#include "tools/draw/text.h"

#include <math.h>
#include <stdlib.h>

#include <fontconfig/fontconfig.h>
#include <ft2build.h>
#include FT_FREETYPE_H

#include "tools/common/report.h"

struct text_font {
    FT_Library library;
    FT_Face face;
};

// To be freed; NULL: there is none.
static char *find_file(int *index)
{
    FcPattern *asked = FcNameParse((const FcChar8 *)"DejaVu Sans,sans-serif");
    FcChar8 *name = NULL;
    char *out = NULL;
    FcResult result;
    if (!asked || !FcConfigSubstitute(NULL, asked, FcMatchPattern)) {
        if (asked)
            FcPatternDestroy(asked);
        return NULL;
    }
    FcDefaultSubstitute(asked);
    FcPattern *found = FcFontMatch(NULL, asked, &result);
    if (found && FcPatternGetString(found, FC_FILE, 0, &name) == FcResultMatch)
        out = strdup((const char *)name);
    if (!found || FcPatternGetInteger(found, FC_INDEX, 0, index) != FcResultMatch)
        *index = 0;
    if (found)
        FcPatternDestroy(found);
    FcPatternDestroy(asked);
    return out;
}

enum weft_result text_font_create(text_font **out)
{
    int index = 0;
    char *file = find_file(&index);
    text_font *font = *out = calloc(1, sizeof *font);
    enum weft_result res = WEFT_ERR_MEMORY;
    if (!font || FT_Init_FreeType(&font->library)) {
        report_error("out of memory for the font of an annotated picture");
        goto fail;
    }
    if (file && FT_New_Face(font->library, file, index, &font->face) == 0 &&
        FT_IS_SCALABLE(font->face))
        res = WEFT_OK;
    else
        report_error("--annotate needs a font (Debian package fonts-dejavu-core): %s%s",
                     file ? "this cannot be read: " : "fontconfig finds none", file ? file : "");
fail:
    free(file);
    if (res != WEFT_OK)
        text_font_destroy(out);
    return res;
}

void text_font_destroy(text_font **font)
{
    if (*font && (*font)->face)
        FT_Done_Face((*font)->face);
    if (*font && (*font)->library)
        FT_Done_FreeType((*font)->library);
    free(*font);
    *font = NULL;
}

// Moves on by a character.
static FT_ULong take_character(const char **text)
{
    const unsigned char *s = (const unsigned char *)*text;
    const int more = *s < 0x80 ? 0 : *s >> 5 == 6 ? 1 : *s >> 4 == 14 ? 2 : *s >> 3 == 30 ? 3 : -1;
    FT_ULong code = more > 0 ? *s & (0x3fu >> more) : *s;
    for (int i = 1; i <= more; i++) {
        if (s[i] >> 6 != 2) { // the next character starts here
            *text += i;
            return '?';
        }
        code = code << 6 | (s[i] & 0x3fu);
    }
    *text += more < 0 ? 1 : 1 + more;
    return more < 0 ? '?' : code;
}

double text_lay_out(text_font *font, const char *text, int size,
                    void (*glyph)(void *priv, int pen, const struct text_glyph *glyph), void *priv)
{
    const FT_Face face = font->face;
    FT_UInt before = 0;
    double pen = 0.0;
    FT_Set_Pixel_Sizes(face, 0, (FT_UInt)size);
    while (*text) {
        const FT_UInt index = FT_Get_Char_Index(face, take_character(&text));
        FT_Vector kerning = {0, 0};
        if (before)
            FT_Get_Kerning(face, before, index, FT_KERNING_UNFITTED, &kerning);
        pen += (double)kerning.x / 64.0;
        before = index;
        if (FT_Load_Glyph(face, index, glyph ? FT_LOAD_RENDER : FT_LOAD_DEFAULT))
            continue;
        const FT_GlyphSlot slot = face->glyph;
        if (glyph && slot->bitmap.pixel_mode == FT_PIXEL_MODE_GRAY)
            glyph(priv, (int)lrint(pen),
                  &(struct text_glyph){.x = slot->bitmap_left,
                                       .y = -slot->bitmap_top,
                                       .width = (int)slot->bitmap.width,
                                       .height = (int)slot->bitmap.rows,
                                       .stride = slot->bitmap.pitch,
                                       .coverage = slot->bitmap.buffer});
        pen += (double)slot->advance.x / 64.0;
    }
    return pen;
}
