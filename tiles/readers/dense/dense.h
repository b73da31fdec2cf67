// SPDX-License-Identifier: BSD-3-Clause
// tiles/readers/dense/dense.h - files of dense samples: what lies where in them, and their bricks
// (not installed). NRRD, NIfTI and raw files become the same record, which answers the questions
// of volume_wire.h. Samples are read where they lie in the file, or from memory where they had to
// be decoded.
#ifndef WEFT_TILES_READERS_DENSE_DENSE_H
#define WEFT_TILES_READERS_DENSE_DENSE_H

#include <stdio.h>

#include "tiles/process/server.h"
#include "tiles/volume/volume_wire.h"

WEFT_BEGIN_DECLS

// Axes of a file, of which up to three are those of space; grids of a file, metadata.
enum { WEFT_DENSE_AXES = 16, WEFT_DENSE_GRIDS = 65536, WEFT_DENSE_METADATA = 256 };

// Of a file's other axes one of three vector components is the grids' components; all others make
// a grid of each of their entries.
struct weft_dense_axis {
    uint64_t size;   // samples along it, at least 1
    int64_t stride;  // bytes from one sample to the next
    bool components; // of a vector, size 3
};

// {.fd = -1} is empty. Release it with weft_dense_clear.
struct weft_dense {
    enum weft_sample_type type;
    bool swapped;            // samples have the other byte order than this machine
    double slope, intercept; // value = slope * sample + intercept; 1 and 0: the sample as it is
    struct weft_dense_axis space[3], other[WEFT_DENSE_AXES];
    int other_count;
    double index_to_world[3][4];
    struct weft_metadata metadata[WEFT_DENSE_METADATA];
    size_t metadata_count;
    unsigned char *memory; // decoded samples, owned; NULL: they lie in the file
    int fd;                // borrowed where it is the server's, else owned
    bool owns_fd;
    uint64_t start; // bytes of the file before the first sample
    // Set by weft_dense_handle.
    bool ready;
    char stem[200];
    uint64_t grid_count, grid; // the grid that is open
    int component;
    bool open, rest;
};
void weft_dense_clear(struct weft_dense *dense);

// Fills in a record, in which nothing is set. Returns WEFT_OK or what weft_server_fail returned.
typedef enum weft_result (*weft_dense_read_header)(struct weft_server *server,
                                                   struct weft_dense *dense);

// Answers a request for a list, a grid or bricks; the header is read at the first one.
enum weft_result weft_dense_handle(struct weft_server *server, struct weft_dense *dense,
                                   weft_dense_read_header read_header);

// The header of a raw file: the layout that came with the request.
enum weft_result weft_dense_read_raw(struct weft_server *server, struct weft_dense *dense);

// Adds an entry; empty values, and those beyond the most, are left out.
void weft_dense_note(struct weft_dense *dense, const char *key, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

// Bytes of all samples of axes of these sizes. Fails where a size is 0 or over the limit of index
// coordinates, or where the product has more than 2^62.
enum weft_result weft_dense_count_bytes(struct weft_server *server, const struct weft_dense *dense,
                                        uint64_t *bytes);

// Strides of samples that are stored one after another, the first axis fastest; axis: those of
// space and the others in the order in which they are stored.
void weft_dense_pack(enum weft_sample_type type, struct weft_dense_axis *const *axis, int count);

// The samples lie in a file of file_bytes, from `start` on, as they are. Fails where they do not
// fit, with both numbers.
enum weft_result weft_dense_lie_in_file(struct weft_server *server, struct weft_dense *dense,
                                        int fd, uint64_t start);

// Memory for all samples, which are stored in stored_bytes and so cannot be more than `ratio`
// times that. Fails with both numbers, also where it is over the memory limit.
enum weft_result weft_dense_allocate(struct weft_server *server, struct weft_dense *dense,
                                     uint64_t stored_bytes, uint64_t ratio);

// Opens a file that lies in the folder of the server's; a name leads nowhere else. Returns the
// descriptor, or -1 after weft_server_fail.
int weft_dense_open_beside(struct weft_server *server, const char *name);

// ---- samples ------------------------------------------------------------------------------------

// Values of `count` samples that lie `stride` bytes apart; rest: what floats lack of them.
void weft_dense_convert(const struct weft_dense *dense, const unsigned char *from, int64_t stride,
                        size_t count, float *out);
// What floats do not hold of them (volume.h: values_rounded etc.).
void weft_dense_count_values(const struct weft_dense *dense, const unsigned char *from,
                             int64_t stride, size_t count, struct weft_volume_info *info);

WEFT_END_DECLS
#endif
