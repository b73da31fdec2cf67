// SPDX-License-Identifier: BSD-3-Clause
// The formats: nifti1.h and nifti2.h of the NIfTI Data Format Working Group. Units, intents and
// orientations are named as libnifti2 names them.
#include "tiles/readers/dense/nifti.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <nifti/nifti2_io.h>

#include "filter/check.h"

// ---- the header ---------------------------------------------------------------------------------

// Decompressed where it is compressed.
static bool read_through_zlib(int fd, uint64_t skip, void *out, uint64_t size)
{
    gzFile stream = gzdopen(dup(fd), "rb");
    unsigned char *to = out;
    bool good = stream && lseek(fd, 0, SEEK_SET) == 0 &&
                gzseek(stream, (z_off_t)skip, SEEK_SET) == (z_off_t)skip;
    while (good && size) {
        const unsigned int piece = size < (1u << 30) ? (unsigned int)size : 1u << 30;
        const int n = gzread(stream, to, piece);
        good = n > 0;
        if (good) {
            to += n;
            size -= (uint64_t)n;
        }
    }
    if (stream)
        gzclose(stream);
    return good;
}

static bool is_gzip(int fd)
{
    unsigned char magic[2] = {0, 0};
    return pread(fd, magic, sizeof magic, 0) == sizeof magic && magic[0] == 0x1f &&
           magic[1] == 0x8b;
}

static enum weft_result fail_header(struct weft_server *server, const char *why)
{
    return weft_server_fail(server, WEFT_ERR_FORMAT, "not a NIfTI header: %s", why);
}

// By the library, which swaps bytes and makes matrices of quaternions.
static enum weft_result load_header(struct weft_server *server, nifti_image **out)
{
    union {
        nifti_1_header first;
        nifti_2_header second;
        char bytes[sizeof(nifti_2_header)];
    } header;
    memset(&header, 0, sizeof header);
    if (!read_through_zlib(server->input_fd, 0, header.bytes, sizeof header.first))
        return fail_header(server, "the file is too short, or cannot be decompressed");
    const int version = nifti_header_version(header.bytes, sizeof header.first);
    if (version == 0)
        return weft_server_fail(server, WEFT_ERR_UNSUPPORTED,
                                "an ANALYZE 7.5 header, which does not tell where it lies");
    if (version != 1 && version != 2)
        return fail_header(server, "it has neither version's magic number");
    if (version == 2 && !read_through_zlib(server->input_fd, 0, header.bytes, sizeof header.second))
        return fail_header(server, "the file is too short, or cannot be decompressed");
    *out = version == 1 ? nifti_convert_n1hdr2nim(header.first, NULL)
                        : nifti_convert_n2hdr2nim(header.second, NULL);
    return *out ? WEFT_OK : fail_header(server, "libnifti2 does not take its sizes or its type");
}

// ---- samples ------------------------------------------------------------------------------------

static bool set_type(const nifti_image *image, struct weft_dense *dense)
{
    static const struct {
        int code;
        enum weft_sample_type type;
    } types[] = {{DT_UINT8, WEFT_SAMPLE_UINT8},     {DT_INT8, WEFT_SAMPLE_INT8},
                 {DT_UINT16, WEFT_SAMPLE_UINT16},   {DT_INT16, WEFT_SAMPLE_INT16},
                 {DT_UINT32, WEFT_SAMPLE_UINT32},   {DT_INT32, WEFT_SAMPLE_INT32},
                 {DT_UINT64, WEFT_SAMPLE_UINT64},   {DT_INT64, WEFT_SAMPLE_INT64},
                 {DT_FLOAT32, WEFT_SAMPLE_FLOAT},   {DT_FLOAT64, WEFT_SAMPLE_DOUBLE},
                 {DT_RGB24, WEFT_SAMPLE_UINT8},     {DT_RGBA32, WEFT_SAMPLE_UINT8},
                 {DT_COMPLEX64, WEFT_SAMPLE_FLOAT}, {DT_COMPLEX128, WEFT_SAMPLE_DOUBLE}};
    for (size_t i = 0; i < WEFT_COUNT(types); i++)
        if (types[i].code == image->datatype) {
            dense->type = types[i].type;
            return true;
        }
    return false;
}

static bool is_vector(const nifti_image *image, int dimension)
{
    return dimension == 5 && image->dim[5] == 3 &&
           (image->intent_code == NIFTI_INTENT_VECTOR ||
            image->intent_code == NIFTI_INTENT_DISPVECT ||
            image->intent_code == NIFTI_INTENT_RGB_VECTOR ||
            image->intent_code == NIFTI_INTENT_POINTSET);
}

// Samples of one voxel that lie together are an axis of their own, the fastest one.
static enum weft_result set_axes(struct weft_server *server, const nifti_image *image,
                                 struct weft_dense *dense)
{
    struct weft_dense_axis *stored[WEFT_DENSE_AXES];
    int count = 0;
    if (!set_type(image, dense))
        return weft_server_fail(server, WEFT_ERR_UNSUPPORTED, "samples of the type %s",
                                nifti_datatype_to_string(image->datatype));
    const uint64_t together = (uint64_t)image->nbyper / weft_sample_sizes[dense->type];
    if (together > 1) {
        dense->other[0] = (struct weft_dense_axis){.size = together, .components = together == 3};
        stored[count++] = &dense->other[dense->other_count++];
    }
    for (int i = 0; i < 3; i++) {
        dense->space[i].size = image->ndim > i ? (uint64_t)image->dim[i + 1] : 1;
        stored[count++] = &dense->space[i];
    }
    for (int i = 4; i <= 7 && i <= image->ndim; i++) {
        dense->other[dense->other_count] = (struct weft_dense_axis){
            .size = (uint64_t)image->dim[i], .components = together != 3 && is_vector(image, i)};
        stored[count++] = &dense->other[dense->other_count++];
    }
    weft_dense_pack(dense->type, stored, count);
    return WEFT_OK;
}

// The other file of a pair: "x.hdr" has "x.img" or "x.img.gz", and "x.hdr.gz" likewise.
static int open_image(struct weft_server *server)
{
    const char *slash = strrchr(server->path, '/'), *name = slash ? slash + 1 : server->path;
    const char *dot = strstr(name, ".hdr");
    char beside[300];
    if (!dot) {
        weft_server_fail(server, WEFT_ERR_FORMAT,
                         "a header without samples, whose name does not end in .hdr");
        return -1;
    }
    for (int i = 0; i < 2; i++) {
        snprintf(beside, sizeof beside, "%.*s.img%s", (int)(dot - name > 200 ? 200 : dot - name),
                 name, i ? ".gz" : "");
        server->answer.result = WEFT_OK;
        const int fd = weft_dense_open_beside(server, beside);
        if (fd >= 0)
            return fd;
    }
    return -1;
}

static enum weft_result decompress(struct weft_server *server, struct weft_dense *dense, int fd,
                                   uint64_t start)
{
    uint64_t bytes;
    struct stat st;
    enum weft_result res = weft_dense_count_bytes(server, dense, &bytes);
    if (res == WEFT_OK && fstat(fd, &st))
        res =
            weft_server_fail(server, WEFT_ERR_OPEN, "cannot read the samples: %s", strerror(errno));
    // Deflate packs 258 bytes into 2 bits of its longest matches (RFC 1951).
    if (res == WEFT_OK)
        res = weft_dense_allocate(server, dense, (uint64_t)st.st_size, 1040);
    if (res == WEFT_OK && !read_through_zlib(fd, start, dense->memory, bytes))
        res = weft_server_fail(server, WEFT_ERR_FORMAT,
                               "the header tells of %llu bytes of samples from byte %llu on, which "
                               "its compressed data does not have, or it is damaged",
                               (unsigned long long)bytes, (unsigned long long)start);
    return res;
}

static enum weft_result find_samples(struct weft_server *server, const nifti_image *image,
                                     struct weft_dense *dense)
{
    const bool pair =
        image->nifti_type == NIFTI_FTYPE_NIFTI1_2 || image->nifti_type == NIFTI_FTYPE_NIFTI2_2;
    const int fd = pair ? open_image(server) : server->input_fd;
    if (fd < 0)
        return (enum weft_result)server->answer.result;
    enum weft_result res;
    if (image->iname_offset < 0)
        res = weft_server_fail(server, WEFT_ERR_FORMAT, "samples from byte %lld on",
                               (long long)image->iname_offset);
    else if (is_gzip(fd))
        res = decompress(server, dense, fd, (uint64_t)image->iname_offset);
    else
        res = weft_dense_lie_in_file(server, dense, fd, (uint64_t)image->iname_offset);
    const bool keep = pair && res == WEFT_OK && !dense->memory;
    dense->owns_fd = keep;
    if (pair && !keep)
        close(fd);
    return res;
}

// ---- where it lies ------------------------------------------------------------------------------

// The standard's order: the affine matrix, the rotation, or sizes of voxels alone.
static const char *set_transform(const nifti_image *image, struct weft_dense *dense)
{
    const nifti_dmat44 *m = image->sform_code > 0 ? &image->sto_xyz : &image->qto_xyz;
    if (image->sform_code > 0 || image->qform_code > 0) {
        for (int r = 0; r < 3; r++)
            for (int c = 0; c < 4; c++)
                dense->index_to_world[r][c] = m->m[r][c];
        return image->sform_code > 0 ? "sform" : "qform";
    }
    for (int i = 0; i < 3; i++) {
        const double size = fabs(image->pixdim[i + 1]);
        dense->index_to_world[i][i] = isfinite(size) && size > 0.0 ? size : 1.0;
    }
    return "pixdim";
}

static void note_header(const nifti_image *image, struct weft_dense *dense, const char *transform)
{
    const int code = image->sform_code > 0 ? image->sform_code : image->qform_code;
    const bool second =
        image->nifti_type == NIFTI_FTYPE_NIFTI2_1 || image->nifti_type == NIFTI_FTYPE_NIFTI2_2;
    weft_dense_note(dense, "version", "NIfTI-%d", second ? 2 : 1);
    weft_dense_note(dense, "transform", "%s (%s)", transform, nifti_xform_string(code));
    if (code > 0)
        weft_dense_note(dense, "space", "right-anterior-superior");
    weft_dense_note(dense, "space units", "%s", nifti_units_string(image->xyz_units));
    if (image->ndim > 3) {
        weft_dense_note(dense, "time units", "%s", nifti_units_string(image->time_units));
        weft_dense_note(dense, "time step", "%.9g", image->dt);
        weft_dense_note(dense, "time origin", "%.9g", image->toffset);
    }
    weft_dense_note(dense, "datatype", "%s", nifti_datatype_to_string(image->datatype));
    if (dense->slope != 1.0 || dense->intercept != 0.0)
        weft_dense_note(dense, "scale", "%.9g * stored + %.9g", dense->slope, dense->intercept);
    if (image->intent_code)
        weft_dense_note(dense, "intent", "%s (%g, %g, %g)", nifti_intent_string(image->intent_code),
                        image->intent_p1, image->intent_p2, image->intent_p3);
    weft_dense_note(dense, "intent name", "%.*s", (int)sizeof image->intent_name,
                    image->intent_name);
    weft_dense_note(dense, "description", "%.*s", (int)sizeof image->descrip, image->descrip);
    weft_dense_note(dense, "auxiliary file", "%.*s", (int)sizeof image->aux_file, image->aux_file);
    if (image->cal_max != 0.0 || image->cal_min != 0.0)
        weft_dense_note(dense, "display range", "%.9g to %.9g", image->cal_min, image->cal_max);
}

static enum weft_result take(struct weft_server *server, const nifti_image *image,
                             struct weft_dense *dense)
{
    enum weft_result res = set_axes(server, image, dense);
    if (res != WEFT_OK)
        return res;
    // Colours are not scaled (nifti1.h, "Data Scaling").
    const bool colours = image->datatype == DT_RGB24 || image->datatype == DT_RGBA32;
    if (image->scl_slope != 0.0 && !colours && isfinite(image->scl_slope)) {
        dense->slope = image->scl_slope;
        dense->intercept = isfinite(image->scl_inter) ? image->scl_inter : 0.0;
    }
    dense->swapped = image->byteorder != nifti_short_order() && weft_sample_sizes[dense->type] > 1;
    note_header(image, dense, set_transform(image, dense));
    return find_samples(server, image, dense);
}

enum weft_result weft_nifti_read_header(struct weft_server *server, struct weft_dense *dense)
{
    nifti_image *image = NULL;
    nifti_set_debug_level(0);
    enum weft_result res = load_header(server, &image);
    if (res == WEFT_OK)
        res = take(server, image, dense);
    if (image)
        nifti_image_free(image);
    return res;
}
