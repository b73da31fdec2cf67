// SPDX-License-Identifier: BSD-3-Clause
#include "passes/fused/resident_impl.h"

#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#include "filter/threads.h"
#include "passes/fused/lines/lines.h"
#include "passes/gl/context_backend.h"
#include "tiles/volume/volume_cache.h"
#include "tiles/volume/volume_impl.h"

static const uint64_t DEFAULT_MEMORY = UINT64_C(1) << 30, DEFAULT_BRICKS = UINT64_C(1) << 28;
enum {
    MAX_THREADS = 16,        // that lay out blocks
    MAX_CONSTANTS = 1 << 22, // cells of one value that are remembered
};

// ---- what slices may read it --------------------------------------------------------------------

static int tap_offset(int width)
{
    return width % 2 ? (width - 1) / 2 : width / 2 - 1;
}

int weft_resident_lead(const weft_resident *r, int width)
{
    return tap_offset(r->info.kernel.width) - tap_offset(width);
}

enum weft_result weft_resident_check(const weft_resident *r, const struct weft_log *log,
                                     const weft_volume *volume, const struct weft_kernel *kernel)
{
    const struct weft_kernel *own = &r->info.kernel;
    char name[64], own_name[64];
    if (volume != r->volume && volume != r->voxels) {
        weft_error(log, "the slice's volume is not the one that stays resident");
        return WEFT_ERR_ARGUMENT;
    }
    if (own->prefiltered || kernel->prefiltered ? weft_kernel_same(own, kernel)
                                                : kernel->width <= own->width)
        return WEFT_OK;
    weft_kernel_format(kernel, name, sizeof name);
    weft_kernel_format(own, own_name, sizeof own_name);
    weft_error(log, "kernel %s, of %d taps, reads no volume that is resident for %s, of %d%s", name,
               kernel->width, own_name, own->width,
               own->prefiltered || kernel->prefiltered ? ": coefficients are one kernel's" : "");
    return WEFT_ERR_ARGUMENT;
}

struct weft_footprint_shared weft_resident_shared(weft_resident *r)
{
    return (struct weft_footprint_shared){.samples = r->samples,
                                          .coefficients = r->coefficients ? r->kept : NULL,
                                          .kernels = &r->kernels};
}

weft_volume *weft_resident_volume(const weft_resident *r)
{
    return r->coefficients ? r->volume : r->voxels;
}

// ---- making -------------------------------------------------------------------------------------

static enum weft_result set_kernel(weft_resident *r, const struct weft_kernel *kernel)
{
    enum weft_result res = WEFT_OK;
    r->info.kernel = *kernel;
    if (!kernel->info)
        res = weft_kernel_parse(r->log, "catmull-rom", &r->info.kernel);
    if (res == WEFT_OK)
        res = weft_kernel_check(r->log, &r->info.kernel);
    if (res != WEFT_OK || !r->info.kernel.radial)
        return res;
    weft_error(r->log, "kernel %s is radial: a slice multiplies the weights of three axes",
               r->info.kernel.info->name);
    return WEFT_ERR_UNSUPPORTED;
}

static enum weft_result keep_bricks(weft_resident *r, weft_volume *volume, uint64_t bytes,
                                    weft_volume **out)
{
    const enum weft_result res = weft_volume_cache(volume, r->log, out);
    if (res == WEFT_OK)
        weft_volume_cache_limit(*out, weft_volume_in_memory(volume) ? 0 : bytes);
    return res;
}

static enum weft_result set_volumes(weft_resident *r, uint64_t bytes)
{
    weft_volume *base = r->volume;
    enum weft_result res = WEFT_OK;
    if (r->info.kernel.prefiltered) {
        res = keep_bricks(r, r->volume, bytes, &r->samples);
        if (res == WEFT_OK)
            res = weft_volume_prefilter(r->log, r->samples, &r->info.kernel, &r->coefficients);
        base = r->coefficients;
    }
    r->voxels = base;
    if (res != WEFT_OK || weft_volume_in_memory(base))
        return res;
    res = keep_bricks(r, base, bytes, &r->kept);
    r->voxels = r->kept;
    return res;
}

static enum weft_result set_layout(weft_resident *r, const struct weft_resident_params *p)
{
    const int width = r->info.kernel.width;
    const int taps[3] = {width, width, width}, starts[3] = {8, 8, 8};
    enum weft_layout layout = p->layout;
    if (layout == WEFT_LAYOUT_AUTO)
        layout = width < 3 || !r->context ? WEFT_LAYOUT_PLAIN : WEFT_LAYOUT_INTERLEAVED;
    r->info.layout = layout;
    r->info.source = p->source;
    r->range = (struct weft_source_range){p->low, p->high};
    r->info.low = p->low;
    r->info.high = p->high;
    weft_block_layout_init(&r->layout, layout, p->source, taps, starts);
    r->info.block_bytes = r->layout.block_texels * r->layout.texel_bytes;
    if (!r->context && (layout != WEFT_LAYOUT_PLAIN || p->source != WEFT_SOURCE_FLOAT)) {
        weft_error(r->log, "layout %s, as %s, is OpenGL's: in memory blocks are plain floats",
                   weft_layout_name(layout), weft_source_format_name(p->source));
        return WEFT_ERR_UNSUPPORTED;
    }
    if (weft_source_format_holds(p->source, &r->range))
        return WEFT_OK;
    weft_error(r->log,
               "a source of format %s needs a range within +-1e37, 1.2e-38 wide or more: %g to %g "
               "is none",
               weft_source_format_name(p->source), p->low, p->high);
    return WEFT_ERR_ARGUMENT;
}

static uint64_t smaller(uint64_t a, uint64_t b)
{
    return a < b ? a : b;
}

// Cells whose taps may lie on active voxels.
static uint64_t count_cells(const weft_resident *r)
{
    const struct weft_volume_info *info = weft_volume_get_info(r->voxels);
    uint64_t count = 1;
    for (int a = 0; a < 3; a++) {
        const int64_t length = (int64_t)info->active_max[a] - info->active_min[a];
        count =
            smaller(count * (uint64_t)((length + r->info.kernel.width) / 8 + 3), UINT64_C(1) << 31);
    }
    return count;
}

static enum weft_result set_capacity(weft_resident *r, uint64_t memory_bytes)
{
    const uint64_t bytes = memory_bytes ? memory_bytes : DEFAULT_MEMORY;
    const uint64_t texels =
        r->context ? (uint64_t)weft_context_get_info(r->context)->max_buffer_texels : INT32_MAX;
    const uint64_t most = smaller(texels, INT32_MAX) / r->layout.block_texels;
    r->info.capacity = smaller(smaller(bytes / r->info.block_bytes, most), count_cells(r));
    r->cells.limit = (size_t)r->info.capacity;
    r->constants.limit = MAX_CONSTANTS;
    if (r->info.capacity > 0)
        return WEFT_OK;
    if (most == 0)
        weft_error(r->log, "a block takes %zu texels; the context holds %" PRIu64,
                   r->layout.block_texels, texels);
    else
        weft_error(r->log, "a block takes %" PRIu64 " bytes; the budget is %" PRIu64,
                   r->info.block_bytes, bytes);
    return WEFT_ERR_LIMIT;
}

// Blocks are written into memory for the first time, page by page: large pages are several times as
// fast. Where there are none, nothing changes.
static void advise_pages(char *memory, size_t bytes)
{
    const uintptr_t page = UINT64_C(1) << 21, start = ((uintptr_t)memory + page - 1) / page * page;
    const uintptr_t end = ((uintptr_t)memory + bytes) / page * page;
    if (end > start)
        madvise((void *)start, end - start, MADV_HUGEPAGE);
}

// The places. Of memory that is not written nothing is taken; a buffer grows as places are taken.
static enum weft_result create_places(weft_resident *r)
{
    const size_t capacity = (size_t)r->info.capacity;
    r->blocks = malloc(capacity * sizeof *r->blocks);
    r->threads = weft_threads_available();
    r->threads = r->threads < MAX_THREADS ? r->threads : MAX_THREADS;
    r->boxes = malloc((size_t)r->threads * (size_t)r->layout.span[0] * (size_t)r->layout.span[1] *
                      (size_t)r->layout.span[2] * sizeof *r->boxes);
    if (!r->context) {
        const size_t bytes = capacity * (size_t)r->info.block_bytes;
        // Vectors read past the last row; what they find there does not count.
        r->texels = calloc(bytes + WEFT_LINE_SAMPLES * sizeof(float), 1);
        if (r->texels)
            advise_pages(r->texels, bytes);
    }
    if (!r->blocks || !r->boxes || (!r->context && !r->texels)) {
        weft_error(r->log, "not enough memory for %zu blocks of %" PRIu64 " bytes", capacity,
                   r->info.block_bytes);
        return WEFT_ERR_MEMORY;
    }
    return WEFT_OK;
}

enum weft_result weft_resident_create(const struct weft_resident_params *params,
                                      weft_resident **out)
{
    *out = NULL;
    const struct weft_resident_params *p = params;
    weft_resident *r = NULL;
    enum weft_result res = WEFT_ERR_ARGUMENT;
    weft_require(p->log, p->volume != NULL);
    weft_require_enum(p->log, p->layout, WEFT_LAYOUT_PLAIN);
    weft_require_enum(p->log, p->source, WEFT_SOURCE_UNORM8);
    r = calloc(1, sizeof *r);
    if (!r) {
        weft_error(p->log, "not enough memory for a resident volume");
        return WEFT_ERR_MEMORY;
    }
    r->log = p->log;
    r->volume = p->volume;
    r->context = p->context;
    res = set_kernel(r, &p->kernel);
    if (res == WEFT_OK)
        res = set_volumes(r, p->brick_bytes ? p->brick_bytes : DEFAULT_BRICKS);
    if (res == WEFT_OK)
        res = set_layout(r, p);
    if (res == WEFT_OK)
        res = set_capacity(r, p->memory_bytes);
    if (res == WEFT_OK)
        res = create_places(r);
    if (res != WEFT_OK)
        goto fail;
    *out = r;
    return WEFT_OK;
fail:
    weft_resident_destroy(&r);
    return res;
}

static void destroy_objects(weft_resident *r)
{
    const GladGLContext *gl = &r->context->gl;
    if (weft_context_enter(r->context) != WEFT_OK)
        return;
    weft_gl_buffer_destroy(gl, &r->buffer);
    weft_fused_objects_destroy(gl, &r->objects);
    weft_context_leave(r->context);
}

void weft_resident_keep(weft_resident *r, void *kept, void (*release)(void *kept))
{
    if (r->kept_by_slice)
        r->free_kept(r->kept_by_slice);
    r->kept_by_slice = kept;
    r->free_kept = release;
}

void *weft_resident_take(weft_resident *r, void (*release)(void *kept))
{
    void *kept = r->free_kept == release ? r->kept_by_slice : NULL;
    if (kept)
        r->kept_by_slice = NULL;
    return kept;
}

void weft_resident_destroy(weft_resident **resident)
{
    weft_resident *r = resident ? *resident : NULL;
    if (!r)
        return;
    weft_resident_keep(r, NULL, NULL);
    if (r->context)
        destroy_objects(r);
    weft_brick_reader_close(&r->reader);
    weft_kernel_facts_destroy(&r->kernels);
    weft_volume_destroy(&r->kept);
    weft_volume_destroy(&r->coefficients);
    weft_volume_destroy(&r->samples);
    weft_cell_cache_clear(&r->cells);
    weft_cell_cache_clear(&r->constants);
    free(r->blocks);
    free(r->values);
    free(r->texels);
    free(r->jobs);
    free(r->boxes);
    free(r);
    *resident = NULL;
}

const struct weft_resident_info *weft_resident_get_info(const weft_resident *resident)
{
    return &resident->info;
}

void weft_resident_count(weft_resident *r)
{
    const weft_volume *nearest = r->samples ? r->samples : r->kept;
    r->info.blocks = r->cells.count;
    r->info.bricks_read = nearest ? weft_volume_cache_get_info(nearest)->bricks_read : 0;
    r->info.brick_bytes = r->kept ? weft_volume_cache_get_info(r->kept)->kept_bytes : 0;
    r->info.brick_bytes += r->samples ? weft_volume_cache_get_info(r->samples)->kept_bytes : 0;
}
