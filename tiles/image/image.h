// SPDX-License-Identifier: BSD-3-Clause
// tiles/image/image.h - images of EXR, PNG and TIFF files as planes, and PNG previews.
// Pixel (x, y) of the data window is centred at (x + 0.5, y + 0.5), row 0 on top. Planes are
// [y][x], x fastest, tightly packed.
#ifndef WEFT_TILES_IMAGE_IMAGE_H
#define WEFT_TILES_IMAGE_IMAGE_H

#include <math.h>

#include "../../filter/base.h"
#include "../output/output.h"
#include "../process/limits.h"
#include "transfer.h"

WEFT_BEGIN_DECLS

// What a file is. Files that are read are known by their first bytes, never by their names.
enum weft_image_file_kind {
    WEFT_IMAGE_FILE_EXR, // default, of what is written
    WEFT_IMAGE_FILE_PNG,
    WEFT_IMAGE_FILE_TIFF,
    WEFT_IMAGE_FILE_KIND_COUNT
};
// NULL-ended, in the order of the enum: "EXR", "PNG", "TIFF".
WEFT_API extern const char *const weft_image_file_kind_names[];
// Finds what a file is by its first bytes, 8 of which tell it. Returns false where it is none of
// these. Pure.
WEFT_API bool weft_image_recognise(const void *start, size_t size, enum weft_image_file_kind *out);
// Finds what a file that is to be written is to be by its name's ending: .exr, .png, .tif or .tiff,
// in letters of any case. Returns false where it is none of these.
WEFT_API bool weft_image_file_kind_find(const char *path, enum weft_image_file_kind *out);

// How a file stores a channel's values: EXR as floats, halves or unsigned integers; PNG as codes of
// 8 or 16 bits, which stand for light (transfer.h); TIFF as any of these, of one type for all
// channels. Default, as where a struct is left zero: float.
enum weft_pixel_type {
    WEFT_PIXEL_FLOAT, // 32 bits
    WEFT_PIXEL_HALF,  // 16 bits
    WEFT_PIXEL_UINT,  // unsigned integers of 32 bits, which stand for themselves
    WEFT_PIXEL_UNORM8,
    WEFT_PIXEL_UNORM16,
    WEFT_PIXEL_TYPE_COUNT
};
// NULL-ended, in the order of the enum: "float", "half", "uint", "unorm8", "unorm16".
WEFT_API extern const char *const weft_pixel_type_names[];

// Those up to PIZ are lossless, and written to EXR files; the others are read only.
enum weft_image_compression {
    WEFT_IMAGE_ZIP,   // deflate, 16 lines a chunk (default)
    WEFT_IMAGE_ZIPS,  // deflate, line by line
    WEFT_IMAGE_RLE,   // runs of bytes
    WEFT_IMAGE_NONE,  // as they are
    WEFT_IMAGE_PIZ,   // wavelets, 32 lines: the smallest of noisy images
    WEFT_IMAGE_PXR24, // floats lose 8 bits
    WEFT_IMAGE_B44,   // halves in blocks of 4 x 4
    WEFT_IMAGE_B44A,  // likewise, less for even blocks
    WEFT_IMAGE_DWAA,  // cosines, 32 lines
    WEFT_IMAGE_DWAB,  // cosines, 256 lines
    WEFT_IMAGE_LZW,   // of TIFF files only, which have none, rle (PackBits) and zip (deflate), too
    WEFT_IMAGE_COMPRESSION_COUNT
};
// NULL-ended, in the order of the enum: "zip", "zips", "rle", "none", "piz", "pxr24", ..., "lzw".
WEFT_API extern const char *const weft_image_compression_names[];
// Returns whether weft writes it to EXR files, too; false for values that are none.
WEFT_API bool weft_image_is_writable(enum weft_image_compression compression);

// Levels of a tiled part: smaller images of it in the same file.
enum weft_image_levels {
    WEFT_IMAGE_LEVELS_ONE, // the image alone (default)
    WEFT_IMAGE_LEVELS_MIP, // each half as wide and high as the one before, rounded down, to 1 x 1
    WEFT_IMAGE_LEVELS_RIP, // all halves of widths with all halves of heights; read only
    WEFT_IMAGE_LEVELS_COUNT
};
// Returns how many mip levels an image has, the whole one among them, and a side of one of them:
// rounded down, at least 1. Pure.
WEFT_API int weft_image_level_count(int32_t width, int32_t height);
WEFT_API int32_t weft_image_level_size(int32_t size, int level);

// One channel of an image. To save, zero means the default everywhere but in name and in the
// values: float and half channels need a plane, uint channels integers.
struct weft_image_channel {
    char name[256]; // "R", "left.Z", ... any EXR channel name
    enum weft_pixel_type type;
    bool linear;         // the format's pLinear: perceived brightness is linear in the values
    int32_t sampling[2]; // of columns and rows; to save: {0, 0} or {1, 1}
    float *plane;        // width * rows; NULL in an image that only informs
    // The exact values of uint channels, of which the plane has the nearest floats; NULL for
    // others.
    uint32_t *integers;
};

// Of any type, known to weft or not: "string", "float", "v2f", "timecode", ...
struct weft_image_attribute {
    const char *name, *type; // 1 to 255 bytes each
    const void *data;        // as the format stores it, little-endian
    size_t size;
};

// One part of a file: filled in by weft_image_load, which owns what it points to until
// weft_image_clear, or by the caller to be saved, who then owns it. Thread-safety: read-only use
// from any thread.
struct weft_image {
    char name[256];        // of the part; "" where it has none
    int32_t x, y;          // first pixel of the data window, may be negative
    int32_t width, height; // of the data window in pixels, each > 0
    // Display window, inclusive (to save: all 0 = data window).
    int32_t display_min[2], display_max[2];
    enum weft_image_compression compression; // of EXR and TIFF files
    bool deep;                               // as stored; no deep image is written
    // In tiles of tile[0] x tile[1] pixels; to save {0, 0} is 64 x 64. Otherwise in lines.
    bool tiled;
    int32_t tile[2];
    enum weft_image_levels levels; // of a tiled EXR part; what is loaded is the first, largest one
    // To save LEVELS_MIP: the levels after the first, weft_image_level_count less one of them, with
    // the same channels; their sizes, planes and integers alone are looked at. Owned by the caller.
    // NULL: the first level alone is written, as where `levels` is LEVELS_RIP.
    const struct weft_image *mips;
    enum weft_image_file_kind kind; // of the file it was loaded from; saving does not look at it
    // Of PNG and TIFF files: what the file says of its codes, and the curve that light was found by
    // where they are integers. To save as such: the curve (AUTO: sRGB), and of PNG srgb, gamma and
    // cicp as they are to be said; where these say nothing and the curve is sRGB, sRGB is said.
    struct weft_code_info codes;
    struct weft_transfer transfer;
    // Rows that planes have, the first of them row `first_row` of the data window (default both 0:
    // all). To save, all.
    int32_t first_row, rows;
    size_t channel_count;
    struct weft_image_channel *channels; // in the file's order
    // Whole and in the file's order, but for those that say what is in the members above or how the
    // file is laid out ("channels", "lineOrder", "tiles", ...). One allocation holds a loaded list
    // and all that it points to.
    size_t attribute_count;
    struct weft_image_attribute *attributes;
    int part, part_count; // which of the file's parts this is
};

// Returns the attribute of that name, or NULL; it lives as long as the image's attributes.
WEFT_API const struct weft_image_attribute *weft_image_find(const struct weft_image *image,
                                                            const char *name);

// Writes an attribute's value in words, "1:02:03:04" or "(20 bytes of type x)" where its type is
// unknown; control characters become spaces or '?'. Cut to size, as snprintf does; returns the
// whole length.
WEFT_API size_t weft_image_attribute_format(const struct weft_image_attribute *attribute,
                                            char *text, size_t size);

// Threads that decode or pack one image at once.
enum { WEFT_IMAGE_MAX_THREADS = 1024 };

// Which part of which file. weft_image_list_load uses path, limits and log alone.
struct weft_image_load_params {
    const char *path; // required
    int part;         // from 0 (default 0, the first)
    bool info_only;   // header only: planes stay NULL (default: values, too)
    // Rows of the data window that planes are to have (default both 0: all). Lines and tiles that
    // have none of them are not read.
    int32_t first_row, rows;
    struct weft_transfer transfer; // of integer codes (default: as the file says)
    int threads;                // at once, up to WEFT_IMAGE_MAX_THREADS (default 0: of all cores)
    struct weft_limits limits;  // of the reader process (default: its own, see limits.h)
    const struct weft_log *log; // may be NULL
};
#define WEFT_IMAGE_LOAD_DEFAULTS
#define weft_image_load_params(...)                                                                \
    (&(struct weft_image_load_params){WEFT_IMAGE_LOAD_DEFAULTS __VA_ARGS__})

// Reads an image, whose file is known by its content.
// EXR: a flat scanline or tiled part (level 0) through weft-read-exr, or weft-read-dwa where DWA
// compresses it. Deep parts and subsampled channels have no planes and only inform.
// PNG, TIFF: through weft-read-png and weft-read-tiff, upright, as channels R, G, B or Y, then A,
// and in TIFF extra1, extra2, ...; integer codes become light, and colours are multiplied by alpha
// where the file does not have them so. Directories of a TIFF file are its parts. What EXR has an
// attribute for is one: pixelAspectRatio, xDensity, comments, owner, capDate, and ICCProfile of
// type "icc".
// Ownership: clear it with weft_image_clear. Returns WEFT_ERR_OPEN, _FORMAT, _UNSUPPORTED (deep,
// subsampled, a curve or kind of pixels that weft does not know), _ARGUMENT (there is no such part,
// or there are no such rows), _LIMIT, _READER.
WEFT_API enum weft_result weft_image_load(const struct weft_image_load_params *params,
                                          struct weft_image *out);
// Frees a loaded image's planes and attributes and makes it all zero; accepts NULL and {0}.
WEFT_API void weft_image_clear(struct weft_image *image);

// What a file's parts are.
struct weft_image_list {
    size_t count;
    struct weft_image *images; // without planes
};

// Lists all parts of a file, in its order, deep ones among them; params->part and info_only do not
// matter. Ownership: clear it with weft_image_list_clear. Returns as weft_image_load.
WEFT_API enum weft_result weft_image_list_load(const struct weft_image_load_params *params,
                                               struct weft_image_list *out);
WEFT_API void weft_image_list_clear(struct weft_image_list *list);

// What became of the values, over all parts.
struct weft_image_save_report {
    uint64_t values;      // that were written
    uint64_t overflows;   // finite values that no half holds: stored as infinity
    uint64_t clamped;     // below code 0 or above the largest one, or NaN (as 0): stored as its end
    double rounding;      // largest |stored - given| of the values that stay finite
    uint64_t verified;    // values that were read back
    uint64_t chunks, raw; // blocks of lines, and those that are stored as they are
};

// Returns how many lines a block of a compression has in a file; the last one may have fewer.
WEFT_API int weft_image_block_lines(enum weft_image_compression compression);

// Blocks of lines as a file has them, each behind its size in bytes (4, in the machine's order).
struct weft_image_packed {
    void *data; // NULL where size is 0
    size_t size;
    struct weft_image_save_report report; // of their values
};
// Packs the lines of an image, which may be some lines of a larger one, from a multiple of
// weft_image_block_lines on: what saving that has to do then is little, and may be done by another
// process (weft_image_save_params.packed). threads, log: as in weft_image_save_params. Ownership:
// free it with weft_image_packed_clear. Returns as weft_image_save.
WEFT_API enum weft_result weft_image_pack(const struct weft_image *image, int threads,
                                          const struct weft_log *log,
                                          struct weft_image_packed *out);
WEFT_API void weft_image_packed_clear(struct weft_image_packed *packed); // accepts {0}

// Where and how images are written. The same bytes whatever the number of threads.
struct weft_image_save_params {
    const char *path;               // required
    enum weft_image_file_kind kind; // default: EXR
    bool no_clobber;                // an existing file is an error (default: it is replaced)
    // The finished file is read back by the reader, and every value, window and attribute compared,
    // before it is put in place.
    bool verify;
    int threads; // at once, up to WEFT_IMAGE_MAX_THREADS (default 0: of all cores)
    // Gives the next blocks that weft_image_pack made of lines of the one part, whose first one is
    // `line`, from 0 on; at least one block, borrowed until the next call. It may wait for them.
    // Channels need no planes then, where nothing is verified. NULL (default): lines are packed
    // now.
    enum weft_result (*packed)(void *priv, int line, struct weft_bytes *out);
    void *packed_priv;
    // Of writing: 1 is told before the file is read back and put in place.
    const struct weft_progress *progress; // may be NULL
    const struct weft_log *log;           // may be NULL
};
#define WEFT_IMAGE_SAVE_DEFAULTS
#define weft_image_save_params(...)                                                                \
    (&(struct weft_image_save_params){WEFT_IMAGE_SAVE_DEFAULTS __VA_ARGS__})

// Writes an image as a file of params->kind.
// PNG and TIFF: channels are named R, G, B or Y (or one has any name), and A; layers may name them
// ("left.R"), and TIFF has others after them. All are of one type, unorm8 or unorm16 in PNG. Light
// becomes codes by the image's curve, colours divided by alpha (TIFF of floats keeps them
// multiplied, and says so); rounded to nearest. PNG has one part. TIFF is written by
// weft-write-tiff, and packed with deflate where the compression is none of its own.
// EXR: writes channels of their types: float from planes bit by bit, half from planes rounded to
// nearest even, uint from integers. Each packed chunk is unpacked again and compared. Each
// attribute is written, but for names that the format reserves ("compression"); without
// pixelAspectRatio, screenWindowWidth and screenWindowCenter they are 1, 1 and (0, 0). To a
// temporary file in the same folder, then renamed. Channel and attribute names must differ. Devices
// and pipes are written directly. Returns WEFT_ERR_ARGUMENT (also of packed blocks that are none),
// _UNSUPPORTED (the compression), _LIMIT (a block of lines over 2 GiB), _CANCELLED, _MEMORY,
// _WRITE, and what packed returns.
WEFT_API enum weft_result weft_image_save(const struct weft_image *image,
                                          const struct weft_image_save_params *params);

// Writes count parts likewise. Where they are more than one they have different names, and the same
// display window (all 0 in each or in none), pixelAspectRatio, timeCode and chromaticities. report
// may be NULL.
WEFT_API enum weft_result weft_image_save_parts(const struct weft_image *parts, size_t count,
                                                const struct weft_image_save_params *params,
                                                struct weft_image_save_report *report);

// Colour maps for previews, a NULL-ended list: "grey" (the first), "viridis", "magma" and "cividis"
// (perceptually uniform), "cool-warm" (diverging) and "turbo" (a rainbow). Those with published
// colours show them at i / 255 (cool-warm: i / 32), and are linear between.
struct weft_colour_map {
    const char *name;
    const char *alias;    // as matplotlib calls it, "gray"; NULL: it has this name there
    const char *citation; // what it is for, and whose it is
    // sRGB in [0, 255] at t in [0, 1]. Called from several threads at once.
    void (*colour)(double t, uint8_t rgb[3]);
};
WEFT_API extern const struct weft_colour_map *const weft_colour_map_list[];
// Finds a colour map by its name or alias. Returns NULL where there is none.
WEFT_API const struct weft_colour_map *weft_colour_map_find(const char *name);

// What stands around a preview and is drawn over it: titles, legends, scales. Rows count from the
// top of the whole, which is left + width + right pixels wide.
struct weft_preview_frame {
    int32_t left, right, top, bottom; // pixels around the preview, white at first, >= 0
    // Draws over row y of the whole, RGB, which holds the preview's pixels already. Called in any
    // thread, for several rows at once.
    void (*draw)(const void *priv, int32_t y, uint8_t *rgb); // NULL: nothing
    const void *priv;
};

// A plane, and the colours of its values. Borrowed until the call returns.
struct weft_preview_params {
    const char *path;      // required
    bool no_clobber;       // an existing file is an error (default: it is replaced)
    int32_t width, height; // required
    const float *plane;    // required; width * height
    // Values shown as first and last colour. NAN, or both 0: the finite minimum, maximum.
    float low, high;
    const struct weft_colour_map *colour_map; // default (NULL): grey
    const struct weft_preview_frame *frame;   // default (NULL): none
    int threads;                // at once, up to WEFT_IMAGE_MAX_THREADS (default 0: of all cores)
    const struct weft_log *log; // may be NULL
};
#define WEFT_PREVIEW_DEFAULTS
#define weft_preview_params(...) (&(struct weft_preview_params){WEFT_PREVIEW_DEFAULTS __VA_ARGS__})

// Writes an 8-bit PNG (grey or RGB, with a frame RGB); NaN is shown as magenta in colour maps and
// within frames, as black in grey alone.
// Values beyond the range take its end colours; a range of no width shows its value in the middle
// colour. low > high reverses the colours. Without a finite value the range is 0 to 1.
// range[2], if not NULL, receives the values shown as first and last colour.
// Returns WEFT_ERR_ARGUMENT, _MEMORY, _WRITE.
WEFT_API enum weft_result weft_preview_save(const struct weft_preview_params *params,
                                            float range[2]);

// Planes of red, green and blue light, with alpha associated where there is one. Borrowed until the
// call returns.
struct weft_colour_preview_params {
    const char *path;                // required
    bool no_clobber;                 // an existing file is an error (default: it is replaced)
    int32_t width, height;           // required
    const float *red, *green, *blue; // required; width * height each
    float low, high;            // light shown as code 0 and code 255, low < high. Both 0: 0 and 1
    const struct weft_preview_frame *frame; // default (NULL): none
    int threads;                // at once, up to WEFT_IMAGE_MAX_THREADS (default 0: of all cores)
    const struct weft_log *log; // may be NULL
};
#define WEFT_COLOUR_PREVIEW_DEFAULTS
#define weft_colour_preview_params(...)                                                            \
    (&(struct weft_colour_preview_params){WEFT_COLOUR_PREVIEW_DEFAULTS __VA_ARGS__})

// Writes an 8-bit sRGB PNG over black; light beyond the range takes its ends' codes, and pixels
// with a NaN are magenta. Returns WEFT_ERR_ARGUMENT, _MEMORY, _WRITE.
WEFT_API enum weft_result weft_colour_preview_save(const struct weft_colour_preview_params *params);

WEFT_END_DECLS
#endif
