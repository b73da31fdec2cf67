// SPDX-License-Identifier: BSD-3-Clause
#include "tools/options/saved.h"

#include <stdio.h>

#include "tools/common/report.h"

const char *saved_conflict(const struct option_value *compression,
                           const struct option_value *output)
{
    enum weft_image_file_kind kind;
    const enum weft_image_compression asked = (unsigned)compression->integer[0];
    const bool tiff = output->given && weft_image_file_kind_find(output->text, &kind) &&
                      kind == WEFT_IMAGE_FILE_TIFF;
    if (!compression->given || !tiff || asked == WEFT_IMAGE_ZIP || asked == WEFT_IMAGE_RLE ||
        asked == WEFT_IMAGE_NONE)
        return NULL;
    return "--compression: TIFF is written as zip, rle or none";
}

json_t *saved_json(const struct weft_image_save_report *s)
{
    return json_pack("{s:o,s:o,s:o,s:o,s:o,s:o,s:o}", "values", json_count(s->values), "verified",
                     json_count(s->verified), "overflows", json_count(s->overflows), "clamped",
                     json_count(s->clamped), "rounding", json_number(s->rounding), "chunks",
                     json_count(s->chunks), "raw_chunks", json_count(s->raw));
}

void saved_print(const char *path, const struct weft_image_save_report *s)
{
    char rounding[80] = "";
    if (!s->verified)
        return;
    if (s->rounding > 0.0)
        snprintf(rounding, sizeof rounding, ", rounded to half by at most %.3g", s->rounding);
    report_line("%s: read back, all %llu values are those computed%s", path,
                (unsigned long long)s->verified, rounding);
}

void saved_warn(const char *path, const struct weft_image_save_report *s)
{
    if (s->overflows)
        report_warning("%s: %llu values are beyond %g, the largest half, and become infinity; "
                       "--type float keeps them",
                       path, (unsigned long long)s->overflows, 65504.0);
    if (s->clamped)
        report_warning("%s: %llu values are below 0, above 1 or not finite, and become the codes "
                       "of 0 and 1",
                       path, (unsigned long long)s->clamped);
}

enum weft_result saved_write(const struct weft_image *image, const char *path, bool no_clobber,
                             int threads, struct weft_image_save_report *saved)
{
    enum weft_image_file_kind kind = WEFT_IMAGE_FILE_EXR;
    if (weft_image_file_kind_find(path, &kind) && kind != WEFT_IMAGE_FILE_TIFF)
        kind = WEFT_IMAGE_FILE_EXR; // codes have an option of their own: --preview
    const struct weft_image_save_params params = {
        .path = path,
        .kind = kind,
        .no_clobber = no_clobber,
        .threads = threads,
        .progress = report_writing(path),
        .log = report_log(),
    };
    const enum weft_result res = weft_image_save_parts(image, 1, &params, saved);
    if (res == WEFT_OK)
        saved_warn(path, saved);
    return res;
}
