// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/dense/nrrd.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <teem/nrrd.h>
#include <unistd.h>

#include "filter/check.h"
#include "tiles/readers/dense/nrrd_text.h"

// Teem tells what it was doing, outermost first; the last line is why it failed.
static enum weft_result fail_teem(struct weft_server *server)
{
    char *text = biffGetDone(NRRD);
    char *line = text ? text : NULL;
    for (char *end = text ? text + strlen(text) : NULL; end > text && end[-1] == '\n';)
        *--end = 0;
    if (line && strrchr(line, '\n'))
        line = strrchr(line, '\n') + 1;
    const char *reason = line && strstr(line, ": ") ? strstr(line, ": ") + 2 : line;
    weft_server_fail(server, WEFT_ERR_FORMAT, "Teem says: %.300s",
                     reason && *reason ? reason : "nothing");
    free(text);
    return WEFT_ERR_FORMAT;
}

// ---- axes ---------------------------------------------------------------------------------------

// How Teem's axes became ours.
struct axes {
    int space[3], space_count; // those of space, in order
    int other[WEFT_DENSE_AXES], other_count;
};

static bool has_direction(const Nrrd *nrrd, unsigned int a)
{
    return nrrd->spaceDim > 0 && isfinite(nrrd->axis[a].spaceDirection[0]);
}

static bool is_domain(int kind)
{
    return kind == nrrdKindDomain || kind == nrrdKindSpace;
}

// The axes of space are those with a direction where the header has any; else those whose kind
// says so, or does not say that they are not. Of more than three without a word about them the
// first one is of components if it is short, else the last ones are others.
static bool sort_axes(const Nrrd *nrrd, struct axes *out)
{
    bool directed = false, told = false;
    for (unsigned int a = 0; a < nrrd->dim; a++) {
        directed = directed || has_direction(nrrd, a);
        told = told || (nrrd->axis[a].kind != nrrdKindUnknown && !is_domain(nrrd->axis[a].kind));
    }
    const bool first_is_short = nrrd->dim > 3 && nrrd->axis[0].size <= 4;
    for (unsigned int a = 0; a < nrrd->dim; a++) {
        const int kind = nrrd->axis[a].kind;
        bool space = directed ? has_direction(nrrd, a)
                     : told   ? kind == nrrdKindUnknown || is_domain(kind)
                              : !(first_is_short && a == 0);
        if (space && out->space_count == 3 && !directed)
            space = false;
        if (!space)
            out->other[out->other_count++] = (int)a;
        else if (out->space_count == 3)
            return false;
        else
            out->space[out->space_count++] = (int)a;
    }
    return true;
}

// By its kind, or by its place where it has none.
static bool is_vector(const NrrdAxisInfo *axis, bool first)
{
    switch (axis->kind) {
    case nrrdKindUnknown:
        return first && axis->size == 3;
    case nrrdKindVector:
    case nrrdKindCovariantVector:
    case nrrdKindNormal:
    case nrrdKindPoint:
    case nrrdKind3Color:
    case nrrdKindRGBColor:
    case nrrdKindHSVColor:
    case nrrdKindXYZColor:
    case nrrdKind3Vector:
    case nrrdKind3Gradient:
    case nrrdKind3Normal:
        return axis->size == 3;
    default:
        return false;
    }
}

static enum weft_result set_type(struct weft_server *server, const Nrrd *nrrd,
                                 struct weft_dense *dense)
{
    static const enum weft_sample_type types[nrrdTypeLast] = {
        [nrrdTypeChar] = WEFT_SAMPLE_INT8,   [nrrdTypeUChar] = WEFT_SAMPLE_UINT8,
        [nrrdTypeShort] = WEFT_SAMPLE_INT16, [nrrdTypeUShort] = WEFT_SAMPLE_UINT16,
        [nrrdTypeInt] = WEFT_SAMPLE_INT32,   [nrrdTypeUInt] = WEFT_SAMPLE_UINT32,
        [nrrdTypeLLong] = WEFT_SAMPLE_INT64, [nrrdTypeULLong] = WEFT_SAMPLE_UINT64,
        [nrrdTypeFloat] = WEFT_SAMPLE_FLOAT, [nrrdTypeDouble] = WEFT_SAMPLE_DOUBLE,
    };
    if (nrrd->type <= nrrdTypeUnknown || nrrd->type >= nrrdTypeBlock)
        return weft_server_fail(server, WEFT_ERR_UNSUPPORTED,
                                "samples of the type block are not numbers");
    dense->type = types[nrrd->type];
    return WEFT_OK;
}

static enum weft_result set_axes(struct weft_server *server, const Nrrd *nrrd,
                                 struct weft_dense *dense, struct axes *axes)
{
    struct weft_dense_axis *stored[NRRD_DIM_MAX];
    bool vector = false;
    if (!sort_axes(nrrd, axes))
        return weft_server_fail(server, WEFT_ERR_UNSUPPORTED,
                                "%u axes, more than three of them of space", nrrd->dim);
    if (axes->space_count < 2)
        return weft_server_fail(server, WEFT_ERR_UNSUPPORTED,
                                "%u axes, %d of them of space: neither a picture nor a volume",
                                nrrd->dim, axes->space_count);
    for (int i = 0; i < 3; i++)
        dense->space[i].size = 1;
    for (int i = 0; i < axes->space_count; i++) {
        dense->space[i].size = nrrd->axis[axes->space[i]].size;
        stored[axes->space[i]] = &dense->space[i];
    }
    for (int i = 0; i < axes->other_count; i++) {
        struct weft_dense_axis *other = &dense->other[i];
        const int a = axes->other[i];
        *other = (struct weft_dense_axis){.size = nrrd->axis[a].size};
        other->components = !vector && is_vector(&nrrd->axis[a], a == 0);
        vector = vector || other->components;
        stored[a] = other;
    }
    dense->other_count = axes->other_count;
    weft_dense_pack(dense->type, stored, (int)nrrd->dim);
    return WEFT_OK;
}

// ---- where it lies ------------------------------------------------------------------------------

static double length(const double v[3])
{
    return hypot(hypot(v[0], v[1]), v[2]);
}

// By vectors of space.
static void orient(const Nrrd *nrrd, const struct axes *axes, struct weft_dense *dense)
{
    double(*m)[4] = dense->index_to_world;
    const unsigned int dimension = nrrd->spaceDim < 3 ? nrrd->spaceDim : 3;
    for (int c = 0; c < axes->space_count; c++)
        for (unsigned int r = 0; r < dimension; r++)
            m[r][c] = nrrd->axis[axes->space[c]].spaceDirection[r];
    for (unsigned int r = 0; r < dimension; r++)
        m[r][3] = isfinite(nrrd->spaceOrigin[r]) ? nrrd->spaceOrigin[r] : 0.0;
    if (axes->space_count == 3)
        return;
    const double a[3] = {m[0][0], m[1][0], m[2][0]}, b[3] = {m[0][1], m[1][1], m[2][1]};
    const double across[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                              a[0] * b[1] - a[1] * b[0]};
    for (int r = 0; r < 3; r++)
        m[r][2] = across[r] / length(across);
}

// By spacings, or by the ends of axes: the first sample lies on the lower end of an axis with
// nodes at its ends, and half a cell within it otherwise.
static void space_out(const Nrrd *nrrd, const struct axes *axes, struct weft_dense *dense)
{
    double(*m)[4] = dense->index_to_world;
    for (int c = 0; c < 3; c++)
        m[c][c] = 1.0;
    for (int c = 0; c < axes->space_count; c++) {
        const NrrdAxisInfo *axis = &nrrd->axis[axes->space[c]];
        const bool nodes = axis->center == nrrdCenterNode;
        const double cells = (double)axis->size - (nodes ? 1.0 : 0.0);
        double spacing = axis->spacing;
        if (!isfinite(spacing) && isfinite(axis->min) && isfinite(axis->max) && cells > 0.0)
            spacing = (axis->max - axis->min) / cells;
        m[c][c] = isfinite(spacing) ? spacing : 1.0;
        if (isfinite(axis->min))
            m[c][3] = nodes ? axis->min : axis->min + 0.5 * m[c][c];
    }
}

// ---- metadata -----------------------------------------------------------------------------------

static const char *name_of(const airEnum *names, int value)
{
    return value > 0 ? airEnumStr(names, value) : "";
}

static void join(char *out, size_t size, const char *text, const char *before)
{
    const size_t used = strlen(out);
    snprintf(out + used, size - used, "%s%s", used ? before : "", text && *text ? text : "none");
}

// A text of each axis of space; nothing where all are empty.
static void note_axes(struct weft_dense *dense, const Nrrd *nrrd, const struct axes *axes,
                      const char *key, const char *(*text)(const NrrdAxisInfo *axis))
{
    char all[190] = "";
    bool any = false;
    for (int i = 0; i < axes->space_count; i++) {
        const char *one = text(&nrrd->axis[axes->space[i]]);
        any = any || (one && *one);
        join(all, sizeof all, one, ", ");
    }
    if (any)
        weft_dense_note(dense, key, "%s", all);
}

static const char *units_of(const NrrdAxisInfo *axis)
{
    return axis->units;
}

static const char *label_of(const NrrdAxisInfo *axis)
{
    return axis->label;
}

static const char *center_of(const NrrdAxisInfo *axis)
{
    return name_of(nrrdCenter, axis->center);
}

static void note_kinds(struct weft_dense *dense, const Nrrd *nrrd)
{
    char kinds[190] = "";
    bool any = false;
    for (unsigned int a = 0; a < nrrd->dim; a++) {
        any = any || nrrd->axis[a].kind > 0;
        join(kinds, sizeof kinds, name_of(nrrdKind, nrrd->axis[a].kind), " ");
    }
    if (any)
        weft_dense_note(dense, "kinds", "%s", kinds);
}

static void note_frame(struct weft_dense *dense, const Nrrd *nrrd)
{
    const double(*f)[NRRD_SPACE_DIM_MAX] = nrrd->measurementFrame;
    if (nrrd->spaceDim == 3 && isfinite(f[0][0]))
        weft_dense_note(dense, "measurement frame",
                        "(%.17g,%.17g,%.17g) (%.17g,%.17g,%.17g) (%.17g,%.17g,%.17g)", f[0][0],
                        f[0][1], f[0][2], f[1][0], f[1][1], f[1][2], f[2][0], f[2][1], f[2][2]);
}

static void note_space(struct weft_dense *dense, const Nrrd *nrrd)
{
    char units[190] = "";
    weft_dense_note(dense, "space", "%s", name_of(nrrdSpace, nrrd->space));
    for (unsigned int i = 0; i < nrrd->spaceDim; i++)
        if (nrrd->spaceUnits[i] && *nrrd->spaceUnits[i])
            join(units, sizeof units, nrrd->spaceUnits[i], " ");
    weft_dense_note(dense, "space units", "%s", units);
    note_frame(dense, nrrd);
}

static void note_header(struct weft_dense *dense, const Nrrd *nrrd, const NrrdIoState *io,
                        const struct axes *axes)
{
    weft_dense_note(dense, "encoding", "%s", io->encoding->name);
    note_space(dense, nrrd);
    note_kinds(dense, nrrd);
    note_axes(dense, nrrd, axes, "units", units_of);
    note_axes(dense, nrrd, axes, "labels", label_of);
    note_axes(dense, nrrd, axes, "centers", center_of);
    weft_dense_note(dense, "content", "%s", nrrd->content ? nrrd->content : "");
    weft_dense_note(dense, "sample units", "%s", nrrd->sampleUnits ? nrrd->sampleUnits : "");
    if (isfinite(nrrd->oldMin) || isfinite(nrrd->oldMax))
        weft_dense_note(dense, "old range", "%.17g to %.17g", nrrd->oldMin, nrrd->oldMax);
    for (unsigned int i = 0; i < nrrdKeyValueSize(nrrd); i++) {
        char *key = NULL, *value = NULL;
        nrrdKeyValueIndex(nrrd, &key, &value, i);
        if (key && value)
            weft_dense_note(dense, key, "%s", value);
        free(key);
        free(value);
    }
    for (unsigned int i = 0; i < nrrd->cmtArr->len; i++)
        weft_dense_note(dense, "comment", "%s", nrrd->cmt[i]);
}

// ---- samples ------------------------------------------------------------------------------------

// How many times their stored bytes samples can have, at most: deflate packs 258 bytes into 2 bits
// of its longest matches (1032 to 1, RFC 1951), bzip2 some thousands of times more than that; of
// text a byte cannot be a number of more than 8 bytes.
static uint64_t most_ratio(const NrrdIoState *io)
{
    if (io->encoding == nrrdEncodingGzip)
        return 1040;
    if (io->encoding == nrrdEncodingBzip2)
        return 1 << 16;
    return io->encoding == nrrdEncodingRaw ? 1 : 8;
}

// A stream of the file that the samples lie in; *fd is its descriptor.
static FILE *open_samples(struct weft_server *server, const struct weft_nrrd_text *text,
                          size_t file, uint64_t *bytes)
{
    struct stat st;
    const int fd =
        text->file_count ? weft_dense_open_beside(server, text->file[file]) : dup(server->input_fd);
    FILE *stream = fd >= 0 ? fdopen(fd, "rb") : NULL;
    if (!stream && fd >= 0)
        close(fd);
    if (stream &&
        (fstat(fd, &st) || fseeko(stream, text->file_count ? 0 : (off_t)text->bytes, SEEK_SET))) {
        fclose(stream);
        stream = NULL;
    }
    if (!stream) {
        if (!server->answer.result)
            weft_server_fail(server, WEFT_ERR_OPEN, "cannot read the samples: %s", strerror(errno));
        return NULL;
    }
    *bytes = (uint64_t)st.st_size;
    return stream;
}

static bool skip(FILE *stream, Nrrd *nrrd, NrrdIoState *io)
{
    return !nrrdLineSkip(stream, io) &&
           (io->encoding->isCompression || !nrrdByteSkip(stream, nrrd, io));
}

static bool swaps(const Nrrd *nrrd, const NrrdIoState *io)
{
    return io->encoding->endianMatters && nrrdElementSize(nrrd) > 1 &&
           io->endian != airEndianUnknown && io->endian != airMyEndian();
}

static enum weft_result use_raw(struct weft_server *server, struct weft_dense *dense, Nrrd *nrrd,
                                NrrdIoState *io, const struct weft_nrrd_text *text)
{
    uint64_t bytes;
    FILE *stream = open_samples(server, text, 0, &bytes);
    if (!stream)
        return (enum weft_result)server->answer.result;
    enum weft_result res = WEFT_OK;
    off_t start = -1;
    if (!skip(stream, nrrd, io) || (start = ftello(stream)) < 0)
        res = fail_teem(server);
    if (res == WEFT_OK)
        res = weft_dense_lie_in_file(server, dense, fileno(stream), (uint64_t)start);
    dense->fd = res == WEFT_OK ? dup(fileno(stream)) : -1;
    dense->owns_fd = true;
    fclose(stream);
    return res;
}

static enum weft_result decode(struct weft_server *server, struct weft_dense *dense, Nrrd *nrrd,
                               NrrdIoState *io, const struct weft_nrrd_text *text)
{
    const size_t files = text->file_count ? text->file_count : 1;
    const size_t samples = nrrdElementNumber(nrrd), piece = samples / files;
    uint64_t bytes, stored = 0;
    if (samples % files)
        return weft_server_fail(server, WEFT_ERR_FORMAT, "%zu samples cannot lie in %zu files",
                                samples, files);
    for (size_t i = 0; i < files; i++) {
        FILE *stream = open_samples(server, text, i, &bytes);
        if (!stream)
            return (enum weft_result)server->answer.result;
        fclose(stream);
        stored += bytes;
    }
    if (weft_dense_allocate(server, dense, stored, most_ratio(io)) != WEFT_OK)
        return (enum weft_result)server->answer.result;
    nrrd->data = dense->memory;
    for (size_t i = 0; i < files && !server->answer.result; i++) {
        FILE *stream = open_samples(server, text, i, &bytes);
        unsigned char *to = dense->memory + i * piece * nrrdElementSize(nrrd);
        if (stream && (!skip(stream, nrrd, io) || io->encoding->read(stream, to, piece, nrrd, io)))
            fail_teem(server);
        if (stream)
            fclose(stream);
    }
    nrrd->data = NULL;
    return (enum weft_result)server->answer.result;
}

// ---- files --------------------------------------------------------------------------------------

static enum weft_result take(struct weft_server *server, struct weft_dense *dense, Nrrd *nrrd,
                             NrrdIoState *io, const struct weft_nrrd_text *text)
{
    struct axes axes = {0};
    uint64_t bytes;
    enum weft_result res = set_type(server, nrrd, dense);
    if (res == WEFT_OK)
        res = set_axes(server, nrrd, dense, &axes);
    if (res == WEFT_OK)
        res = weft_dense_count_bytes(server, dense, &bytes);
    if (res != WEFT_OK)
        return res;
    if (nrrd->spaceDim > 0)
        orient(nrrd, &axes, dense);
    if (nrrd->spaceDim == 0)
        space_out(nrrd, &axes, dense);
    note_header(dense, nrrd, io, &axes);
    dense->swapped = swaps(nrrd, io);
    if (io->encoding == nrrdEncodingRaw && text->file_count <= 1)
        return use_raw(server, dense, nrrd, io, text);
    return decode(server, dense, nrrd, io, text);
}

enum weft_result weft_nrrd_read_header(struct weft_server *server, struct weft_dense *dense)
{
    struct weft_nrrd_text text;
    enum weft_result res = weft_nrrd_text_read(server, &text);
    Nrrd *nrrd = nrrdNew();
    NrrdIoState *io = nrrdIoStateNew();
    if (res == WEFT_OK && (!nrrd || !io))
        res = weft_server_fail(server, WEFT_ERR_LIMIT, "no memory for the header");
    if (res == WEFT_OK) {
        io->skipData = 1;
        res = nrrdStringRead(nrrd, text.header, io) ? fail_teem(server)
                                                    : take(server, dense, nrrd, io, &text);
    }
    if (nrrd)
        nrrdNuke(nrrd);
    if (io)
        nrrdIoStateNix(io);
    weft_nrrd_text_clear(&text);
    return res;
}
