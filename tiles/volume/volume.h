// SPDX-License-Identifier: BSD-3-Clause
// tiles/volume/volume.h - scalar volumes as bricks: in memory, or in a VDB, NRRD, NIfTI or raw file
// behind a reader process. Index space: voxel (i,j,k) sits at integer coordinates. World space:
// index_to_world. A brick is the 8x8x8 voxels from an origin whose coordinates are multiples of 8,
// stored [z][y][x], x fastest (512 floats). Where there is neither brick nor tile, the background
// value holds.
#ifndef WEFT_TILES_VOLUME_VOLUME_H
#define WEFT_TILES_VOLUME_VOLUME_H

#include <math.h>

#include "../../filter/base.h"
#include "../../filter/kernels/kernel.h"
#include "../process/limits.h"

WEFT_BEGIN_DECLS

// Voxels along a side of a brick, and in it.
enum { WEFT_BRICK_SIZE = 8, WEFT_BRICK_VOXELS = 512 };

// Index coordinates that weft accepts are within +-2^30, so that sums cannot overflow.
#define WEFT_INDEX_LIMIT (INT32_C(1) << 30)

// Where a volume's voxels are. What a file is is told by its content, not by its name; a raw one is
// nothing by itself, and its layout has to be given.
enum weft_volume_format {
    WEFT_VOLUME_MEMORY, // in memory; of a file: none that weft reads
    WEFT_VOLUME_VDB,    // OpenVDB
    WEFT_VOLUME_NRRD,   // Teem's nearly raw raster data, samples within or in other files
    WEFT_VOLUME_NIFTI,  // NIfTI-1 or -2, one file or a pair, gzipped or not
    WEFT_VOLUME_RAW,    // samples, one behind the other
    WEFT_VOLUME_FORMAT_COUNT
};
// "memory", "vdb", "nrrd", "nifti", "raw"; NULL at the end.
WEFT_API extern const char *const weft_volume_format_names[WEFT_VOLUME_FORMAT_COUNT + 1];

// What a file is by its first bytes, of which 4 are looked at: VDB, NRRD or NIfTI, and
// WEFT_VOLUME_MEMORY for none of them, or for less than 4. gzipped files are taken for NIfTI ones.
// Thread-safe.
WEFT_API enum weft_volume_format weft_volume_recognise(const void *start, size_t size);

// How dense files store samples.
enum weft_sample_type {
    WEFT_SAMPLE_UINT8,
    WEFT_SAMPLE_INT8,
    WEFT_SAMPLE_UINT16,
    WEFT_SAMPLE_INT16,
    WEFT_SAMPLE_UINT32,
    WEFT_SAMPLE_INT32,
    WEFT_SAMPLE_UINT64,
    WEFT_SAMPLE_INT64,
    WEFT_SAMPLE_FLOAT,
    WEFT_SAMPLE_DOUBLE,
    WEFT_SAMPLE_TYPE_COUNT
};
// "uint8", "int8", "uint16", ... "float", "double"; NULL at the end. And bytes of a sample.
WEFT_API extern const char *const weft_sample_type_names[WEFT_SAMPLE_TYPE_COUNT + 1];
WEFT_API extern const size_t weft_sample_sizes[WEFT_SAMPLE_TYPE_COUNT];

// What a raw file is.
struct weft_raw_layout {
    int size[3];                // samples along x, y, z (required, each > 0); x is stored fastest
    enum weft_sample_type type; // default uint8
    bool big_endian;            // default: the lowest byte of a sample comes first
    uint64_t skip;              // bytes of the file before the first sample (default 0)
    double spacing[3];          // from one sample to the next, in world units; finite and not 0;
                                // where negative the axis runs backwards (default all 0: 1 each)
    double origin[3];           // where the first sample lies in the world (default 0)
};
#define WEFT_RAW_LAYOUT_DEFAULTS
#define weft_raw_layout(...) (&(struct weft_raw_layout){WEFT_RAW_LAYOUT_DEFAULTS __VA_ARGS__})

// A constant cube of 8, 128 or 4096 voxels a side (OpenVDB's node sizes), aligned to its size.
struct weft_volume_tile {
    int32_t origin[3]; // index coordinates of its first voxel
    int32_t size;      // voxels along a side
    float value;       // of all its voxels
};

// One of a grid's attributes, as text. Longer texts are cut and end in "...".
struct weft_metadata {
    char key[64];
    char value[192];
};

// What a volume is. Texts of files are cleaned (weft_text_clean). A grid's name is what
// weft_volume_open takes, and no other grid's of the file: a longer name is cut and ends in "...",
// and a number in brackets tells equal ones apart.
struct weft_volume_info {
    char name[256];
    enum weft_volume_format format;
    char type[32];       // as stored; VDB: "float", "double", "half", "int32", "bool", of vectors
                         // "vec3s", "vec3d", "vec3h" (halves), "vec3i", and others, which are not
                         // supported; other files: one of weft_sample_type_names, of vectors, too
    char grid_class[32]; // "fog volume", "level set", "staggered", "unknown", ...
    int components;      // 1, or 3 of a grid of vectors
    int component;       // which of them the voxels are, from 0; 0 in lists
    bool supported;      // weft can slice it; in a list: as far as its header tells
    bool empty;          // no active voxel; active_min/max are then 0
    bool clamp_to_edge;  // outside the box the nearest voxel's value holds, not the background
    bool counted;        // the active voxels are known; false in lists of files that do not tell
    enum weft_result result; // of a list: what opening the grid would return, WEFT_OK = supported
    char problem[256];       // of a list: why it is not supported
    double index_to_world[3][4]; // world[r] = sum_c m[r][c] index[c] + m[r][3]; in lists NAN where
                                 // it cannot be read or is not affine, and maybe singular. Of a
                                 // staggered grid's component c, once it is opened, the position of
                                 // its samples: half a voxel along -c from the grid's own, at the
                                 // lower face of the cell (OpenVDB, Types.h: CLASS_STAGGERED)
    int32_t active_min[3], active_max[3]; // box of active voxels, inclusive
    uint64_t active_voxels;
    uint64_t bricks;       // leaf bricks stored
    uint64_t memory_bytes; // of all voxels as weft would hold them: bricks * 512 * 4
    float background;
    // Values that a float does not hold, among the voxels of bricks, the tiles and the background
    // of grids of integers of 32 and 64 bits and of double (0 in lists and for other types).
    // Integers that a file scales count as doubles.
    bool rounded; // each voxel may be the nearest float, off by up to 2^-24 of itself: of doubles
    uint64_t values_rounded;  // integers: replaced by the nearest float; all are over 2^24
    double largest_rounding;  // the largest change of those
    uint64_t values_infinite; // double: finite but beyond float's range, replaced by an infinity
    uint64_t values_tiny;     // double: under 2^-126 but not 0; the float has fewer bits, or is 0
    size_t metadata_count;
    struct weft_metadata *metadata; // owned by the volume or list that holds this record
};

// A volume, wherever its voxels are. Thread-safety: one thread at a time.
typedef struct weft_volume weft_volume;

// ---- voxels already in memory; no process is started -------------------------------------------

// A dense block of voxels. Start from weft_volume_params(...): a background of 0 is a value, and
// not the default.
struct weft_volume_params {
    int size[3];       // voxels along x, y, z (required, each > 0)
    int32_t origin[3]; // index coordinates of the first voxel (default 0)
    float background;  // value outside the data (default NAN = clamp to edge)
    const float *data; // required: [z][y][x], x fastest, tightly packed; borrowed until the call
                       // returns
    double index_to_world[3][4]; // default (all zero): identity
    const char *name;            // default "density"
    const struct weft_log *log;  // borrowed for the volume's life
};
#define WEFT_VOLUME_DEFAULTS .background = NAN,
#define weft_volume_params(...) (&(struct weft_volume_params){WEFT_VOLUME_DEFAULTS __VA_ARGS__})

// Copies the voxels. On failure *out is NULL and the log says which limit and both numbers.
// Returns WEFT_ERR_ARGUMENT (sizes, singular or non-finite transform), WEFT_ERR_LIMIT (index range)
// or WEFT_ERR_MEMORY.
WEFT_API enum weft_result weft_volume_create(const struct weft_volume_params *params,
                                             weft_volume **out);

// Sparse voxels: what pointers lead to is borrowed until the call returns, but for the log.
struct weft_volume_bricks_params {
    size_t brick_count;                   // may be 0
    const int32_t (*brick_origin)[3];     // multiples of 8, any order, no duplicates
    const float *brick_values;            // brick_count * 512, brick after brick
    size_t tile_count;                    // may be 0
    const struct weft_volume_tile *tiles; // disjoint from the bricks and from each other
    float background;                     // value where there is neither (default 0)
    double index_to_world[3][4];          // default (all zero): identity
    const char *name;                     // default "density"
    const char *grid_class;               // default "fog volume"
    const struct weft_log *log;           // may be NULL; borrowed for the volume's life
};
#define WEFT_VOLUME_BRICKS_DEFAULTS
#define weft_volume_bricks_params(...)                                                             \
    (&(struct weft_volume_bricks_params){WEFT_VOLUME_BRICKS_DEFAULTS __VA_ARGS__})

// Creates a volume from sparse voxels, which it copies. Active voxels are those that differ from
// the background, in level sets those with |value| < |background|. Returns as weft_volume_create.
WEFT_API enum weft_result weft_volume_create_bricks(const struct weft_volume_bricks_params *params,
                                                    weft_volume **out);

// ---- files -------------------------------------------------------------------------------------

// A grid of a file. weft_volume_list_load uses path, raw, limits and log alone.
//
// The grids of dense files (NRRD, NIfTI, raw) are named as the file is, without its ending: "brain"
// of brain.nii.gz. Of axes beyond those of space one of three vector components or colours becomes
// the components; each entry of any other (time, gradients, real and imaginary parts) becomes a
// grid, "brain[0]", "brain[1]", ... The box of a dense grid begins at index 0; outside it the
// nearest voxel's value holds (clamp_to_edge). World space is the file's own, with the directions,
// spacing and origin that it has; its name and units are among the metadata. A 2D picture is one
// slice, whose third axis is normal to it, 1 long.
struct weft_volume_open_params {
    const char *path; // required
    const char *grid; // its name as listed or in the file (default: the first of a scalar type, or
                      // of vectors where there is none)
    const struct weft_raw_layout *raw; // the file is taken for a raw one of this layout, which is
                                       // borrowed until the call returns (default: it is what it
                                       // is by its content)
    int component; // of a grid of vectors: which one the volume's voxels are, from 0 (default)
                   // to 2; of a scalar grid 0 only
    bool rest; // values are what floats lack of the grid's: stored - float, so that both together
               // are exact (to 48 bits); 0 where the float is infinite. No warning then.
    struct weft_limits limits;  // of the reader process
    const struct weft_log *log; // may be NULL; borrowed for the volume's life
};
#define WEFT_VOLUME_OPEN_DEFAULTS
#define weft_volume_open_params(...)                                                               \
    (&(struct weft_volume_open_params){WEFT_VOLUME_OPEN_DEFAULTS __VA_ARGS__})

// Starts a reader, which stays until destroy: of a VDB file it loads the grid's tree without its
// voxels; samples of dense files that are not encoded are read where they lie, others are decoded
// whole. Voxels of int32, int64, uint32, uint64 and double are read once to count those that a
// float does not hold, and a warning tells them. Instances, which share another grid's tree, are
// read as grids of their own. The default of limits.memory_bytes grows with a VDB file: 256 MiB and
// 256 times its size, up to 4 GiB. Headers of dense files that tell of more samples than what is
// stored can hold are refused with both numbers; files that an NRRD header names are read from its
// own folder only. Returns WEFT_ERR_OPEN, _FORMAT, _UNSUPPORTED (no grid of a type that weft reads,
// frustum transform), _ARGUMENT (no grid of that name, and the log lists the names; no such
// component), _LIMIT, _READER.
WEFT_API enum weft_result weft_volume_open(const struct weft_volume_open_params *params,
                                           weft_volume **out);

// A volume that is being opened. Starting a reader takes tens of milliseconds of another processor.
// Thread-safety: one thread at a time.
typedef struct weft_volume_opening weft_volume_opening;

// Starts the reader and asks it to open the grid, without waiting. What goes wrong with the file is
// told when it is awaited, and params->log is called there only, but for WEFT_ERR_MEMORY and
// WEFT_ERR_ARGUMENT (no path, a component under 0 or over 2, a layout), which are returned at once
// with *out NULL. Path, grid and layout are copied.
WEFT_API enum weft_result weft_volume_begin(const struct weft_volume_open_params *params,
                                            weft_volume_opening **out);
// Waits for the volume, and leaves NULL behind. Messages and results are those of weft_volume_open.
WEFT_API enum weft_result weft_volume_await(weft_volume_opening **opening, weft_volume **out);
// Ends the reader without waiting for its answer. Accepts &NULL, leaves NULL behind.
WEFT_API void weft_volume_abandon(weft_volume_opening **opening);

// The grids of a file, in its order. Owned by whoever loaded it.
struct weft_volume_list {
    size_t count;
    struct weft_volume_info *grids;
};

// Lists all grids of a file, supported or not, damaged or not, without reading their trees: box and
// voxel count are what the file's metadata claims; background is NAN, bricks and memory_bytes are
// 0. Where the table itself is damaged the grids before the damage are listed, and the last one's
// problem tells how many more there are. Ownership: clear it with weft_volume_list_clear. Returns
// as weft_volume_open; WEFT_OK where at least one grid's name could be read, or there is none.
WEFT_API enum weft_result weft_volume_list_load(const struct weft_volume_open_params *params,
                                                struct weft_volume_list *out);
WEFT_API void weft_volume_list_clear(struct weft_volume_list *list);

// Where and how a volume is written.
struct weft_volume_save_params {
    const char *path;           // required
    bool no_clobber;            // an existing file is an error (default: it is replaced)
    struct weft_limits limits;  // of the writer process
    const struct weft_log *log; // may be NULL
};
#define WEFT_VOLUME_SAVE_DEFAULTS
#define weft_volume_save_params(...)                                                               \
    (&(struct weft_volume_save_params){WEFT_VOLUME_SAVE_DEFAULTS __VA_ARGS__})

// Writes an in-memory volume as a float grid through weft-write-vdb: to a temporary file in the
// same folder, then renamed. Level sets get their inside filled (signed flood fill). Returns
// WEFT_ERR_ARGUMENT for a volume that is not in memory, WEFT_ERR_WRITE, _READER, _LIMIT.
WEFT_API enum weft_result weft_volume_save(const weft_volume *volume,
                                           const struct weft_volume_save_params *params);

// ---- coefficients -------------------------------------------------------------------------------

// What cutting the inverse filter off changes a coefficient by, along one axis, relative to the
// largest |voxel|: the overlap is weft_prefilter_overlap of it (15 voxels for cubics).
#define WEFT_VOLUME_PREFILTER_ERROR 0x1p-28

// Creates a volume whose voxels are the coefficients by which `kernel` interpolates the given
// volume's (filter/kernels/prefilter.h), computed in double when they are read and rounded to
// float. Each depends on the voxels within the overlap along the axes and on nothing else: its
// bytes are the same whatever else is read. Along one axis errors are within 2^-28 of the largest
// |voxel|; in 3D they are within 3 gain^2 2^-28 and half a unit of the last place of coefficients
// of up to gain^3 times it.
//
// Data reaches farther: bricks within the overlap of others are listed, and active_min and _max are
// wider by it, the other counts being the given volume's. Constant regions stay what they are, to
// the bit. A clamp-to-edge volume holds its edge before filtering; its coefficients go on changing
// beyond the box for the length of the overlap, and the wider box is clamped to its edge.
// A voxel that is not finite stays so, in its place, and takes with it all coefficients that depend
// on it by more than WEFT_PREFILTER_MISSING (filter/kernels/prefilter.h): those are NAN.
//
// Borrows `volume`, which must outlive the result and be used by the same thread. Reading takes up
// to 64 MiB on the way. Returns WEFT_ERR_ARGUMENT (weft_prefilter_compute), _LIMIT (index range) or
// _MEMORY.
WEFT_API enum weft_result weft_volume_prefilter(const struct weft_log *log, weft_volume *volume,
                                                const struct weft_kernel *kernel,
                                                weft_volume **out);

// Frees a volume and ends its reader. Accepts &NULL, leaves NULL behind.
WEFT_API void weft_volume_destroy(weft_volume **volume);

// Tells what a volume is; valid until it is destroyed.
WEFT_API const struct weft_volume_info *weft_volume_get_info(const weft_volume *volume);

// ---- what lies where, and the voxels -----------------------------------------------------------

// A slab of index space: the points p with lower <= normal . p <= upper. The normal is finite and
// need not have length 1; the ends may be infinite, not NAN.
struct weft_slab {
    double normal[3], lower, upper;
};

// A box of voxels (inclusive) cut by up to three slabs. A brick meets a region if the box of its
// voxels, [origin, origin + 7], has a point in common with the box and with each slab by itself.
struct weft_region {
    int32_t min[3], max[3];
    int slab_count; // 0 to 3
    struct weft_slab slab[3];
};

// What of a volume meets a region. Owned by whoever asked.
struct weft_brick_list {
    size_t brick_count;
    int32_t (*brick_origin)[3]; // sorted by z, then y, then x; no duplicates
    size_t tile_count;
    struct weft_volume_tile *tiles; // sorted likewise by origin; the background is not listed
};

// Lists the bricks and tiles that meet a region; no voxel is read. A clamp-to-edge volume lists the
// bricks that hold its data, those at its faces also where the region has points that clamp to
// them. Ownership: clear it with weft_brick_list_clear. Returns WEFT_ERR_ARGUMENT (a slab),
// WEFT_ERR_LIMIT, _MEMORY, _READER, _FORMAT (the reader's answer contradicts itself).
WEFT_API enum weft_result weft_volume_find(weft_volume *volume, const struct weft_region *region,
                                           struct weft_brick_list *out);
WEFT_API void weft_brick_list_clear(struct weft_brick_list *list);

// Reads the voxels of listed bricks into values (count * 512 floats, brick after brick in the order
// given). double and int32 values are rounded to float, bool is 0 or 1. Origins are those of bricks
// that weft_volume_find lists. Returns WEFT_ERR_ARGUMENT (an origin that is none), WEFT_ERR_LIMIT,
// _MEMORY, _READER, _FORMAT; values may then be written in part.
WEFT_API enum weft_result weft_volume_read(weft_volume *volume, size_t count,
                                           const int32_t (*brick_origin)[3], float *values);

WEFT_END_DECLS
#endif
