// SPDX-License-Identifier: BSD-3-Clause
// Marks against what 16 x 16 samples of every pixel show, on random scenes of triangles: none that
// shows more than one surface may be without a mark. WEFT_MARKS_SCENES: scenes of each kind.
#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "passes/antialias/marks/marks_impl.h"
#include "tests/passes/antialias/triangles.h"
#include "tests/support/common.h"
#include "tests/support/contexts.h"

enum { SIZE = 64, PIXELS = SIZE * SIZE, MOST = 600, ROW_SAMPLES = 16 };

// ---- scenes -------------------------------------------------------------------------------------

static uint64_t random_state;

// In [0, 1).
static double uniform(void)
{
    uint64_t z = random_state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return (double)((z ^ z >> 31) >> 11) * 0x1p-53;
}

static double between(double low, double high)
{
    return low + (high - low) * uniform();
}

enum kind { SIZES, THIN, TINY, TOUCHING, COINCIDENT, STEEP, PERSPECTIVE, KINDS };
static const char *const kind_names[] = {"sizes",      "thin",  "tiny",       "touching",
                                         "coincident", "steep", "perspective"};

// A corner: about a middle, turned, at a depth of its own.
static void place_corner(enum kind kind, const double middle[3], double angle, double radius,
                         double flat, float out[4])
{
    const double x = radius * between(-1.0, 1.0), y = radius * flat * between(-1.0, 1.0);
    const double spread = kind == STEEP ? 1.0 : 0.2;
    const double depth = fmin(0.99, fmax(-0.99, middle[2] + spread * between(-1.0, 1.0)));
    const double w = kind == PERSPECTIVE ? between(0.3, 2.3) : 1.0;
    out[0] = (float)((middle[0] + x * cos(angle) - y * sin(angle)) * w);
    out[1] = (float)((middle[1] + x * sin(angle) + y * cos(angle)) * w);
    out[2] = (float)(depth * w);
    out[3] = (float)w;
}

// Triangles of 1/2 to 64 pixels, or as `kind` says. Returns the vertices.
static int make_scene(enum kind kind, int triangles, uint64_t seed, struct triangle_vertex *out)
{
    int n = 0;
    random_state = seed;
    for (int t = 0; t < triangles; t++) {
        struct triangle_vertex *v = out + n;
        const double middle[3] = {between(-1.2, 1.2), between(-1.2, 1.2), between(-0.8, 0.8)};
        const double radius = (kind == TINY ? between(0.0, 3.0) : exp2(between(-1.0, 6.0))) / SIZE;
        const double flat = kind == THIN ? exp2(between(-7.0, 0.0)) : 1.0;
        const double angle = between(0.0, 6.2831853);
        const float colour[4] = {(float)uniform(), (float)uniform(), (float)uniform(), 1.0f};
        for (int k = 0; k < 3; k++) {
            place_corner(kind, middle, angle, radius, flat, v[k].position);
            memcpy(v[k].colour, colour, sizeof colour);
            v[k].surface = (uint32_t)t + 1;
        }
        n += 3;
        if (kind == TOUCHING && t > 0) {
            const struct triangle_vertex *other = out + 3 * (int)between(0.0, t);
            memcpy(v[0].position, other[0].position, sizeof v[0].position);
            memcpy(v[1].position, other[1 + (t & 1)].position, sizeof v[1].position);
        }
        if (kind == COINCIDENT && t % 2) {
            memcpy(v + 3, v, 3 * sizeof *v);
            for (int k = 3; k < 6; k++)
                v[k].surface = (uint32_t)(t + triangles) + 1;
            n += 3;
        }
    }
    return n;
}

// ---- truth --------------------------------------------------------------------------------------

struct truth {
    uint8_t mixed[PIXELS];      // samples show several surfaces
    uint32_t surface[PIXELS];   // of the middle
    float mean[PIXELS][3];      // of the samples' colours
    uint32_t sample[PIXELS][2]; // room for one
    float colour[PIXELS][4];    // likewise
};

// Through the marker's own targets.
static void draw_sample(weft_marker *m, struct triangles *scene, const double sample[2],
                        struct truth *out)
{
    static const char head[] = WEFT_HEAD_33 "layout(location = 0) out vec4 c;\n"
                                            "layout(location = 1) out uvec2 s;\n"
                                            "void weft_write(vec4 colour, uint surface)\n"
                                            "{\n"
                                            "    c = colour;\n"
                                            "    s = uvec2(surface, 0u);\n"
                                            "}\n";
    const GladGLContext *gl = &scene->context->gl;
    const struct weft_pass_state state = {.colours = 2, .depth_func = GL_LESS, .depth_write = true};
    struct weft_antialias_pass pass = {.stage = WEFT_STAGE_COLOUR,
                                       .framebuffer = m->colours.framebuffer,
                                       .width = SIZE,
                                       .height = SIZE,
                                       .part = {0, 0, SIZE, SIZE},
                                       .head = head};
    weft_drawing_place(SIZE, SIZE, 0, sample, pass.place);
    weft_pass_state_begin(gl, pass.framebuffer, SIZE, SIZE, &pass.part, &state);
    gl->ClearBufferfv(GL_COLOR, 0, (const GLfloat[4]){0.0f});
    gl->ClearBufferuiv(GL_COLOR, 1, (const GLuint[4]){0});
    gl->ClearBufferfv(GL_DEPTH, 0, &(const GLfloat){1.0f});
    assert_int_equal(
        weft_drawing_run(&log_to_stderr, scene->context, triangles_drawing(scene), &pass, &state),
        WEFT_OK);
    gl->ReadBuffer(GL_COLOR_ATTACHMENT1);
    gl->ReadPixels(0, 0, SIZE, SIZE, GL_RG_INTEGER, GL_UNSIGNED_INT, out->sample);
    gl->ReadBuffer(GL_COLOR_ATTACHMENT0);
    gl->ReadPixels(0, 0, SIZE, SIZE, GL_RGBA, GL_FLOAT, out->colour);
}

static void find_truth(weft_marker *m, struct triangles *scene, struct truth *out)
{
    enum { SAMPLES = ROW_SAMPLES * ROW_SAMPLES };
    memset(out, 0, sizeof *out);
    assert_int_equal(weft_context_enter(scene->context), WEFT_OK);
    draw_sample(m, scene, (const double[2]){0.0, 0.0}, out);
    for (int p = 0; p < PIXELS; p++)
        out->surface[p] = out->sample[p][0];
    for (int s = 0; s < SAMPLES; s++) {
        const double sample[2] = {(s % ROW_SAMPLES + 0.5) / ROW_SAMPLES - 0.5,
                                  (s / ROW_SAMPLES + 0.5) / ROW_SAMPLES - 0.5};
        draw_sample(m, scene, sample, out);
        for (int p = 0; p < PIXELS; p++) {
            out->mixed[p] |= out->sample[p][0] != out->surface[p];
            for (int c = 0; c < 3; c++)
                out->mean[p][c] += out->colour[p][c] / SAMPLES;
        }
    }
    weft_context_leave(scene->context);
}

// Whether the 3 x 3 neighbours show several surfaces.
static bool has_neighbours(const uint32_t *surface, int p)
{
    bool several = false;
    for (int y = p / SIZE - 1; y <= p / SIZE + 1; y++)
        for (int x = p % SIZE - 1; x <= p % SIZE + 1; x++)
            if (x >= 0 && y >= 0 && x < SIZE && y < SIZE)
                several = several || surface[y * SIZE + x] != surface[p];
    return several;
}

// ---- none is missed -----------------------------------------------------------------------------

static weft_marker *create(struct weft_marker_params params)
{
    weft_marker *m = NULL;
    params.width = params.height = SIZE;
    params.log = &log_to_stderr;
    if (!params.context)
        params.context = contexts[0];
    assert_int_equal(weft_marker_create(&params, &m), WEFT_OK);
    // Colours, surfaces with slopes, depths; marks and limits have a rim.
    assert_true(weft_marker_bytes(m) >= (uint64_t)PIXELS * (4 + 8 + 3 + 1 + 4));
    return m;
}

struct counts {
    int64_t mixed, complete, visible, neighbours;      // pixels
    int64_t missed, missed_visible, missed_neighbours; // of the mixed ones
};

static void count_marks(const struct truth *truth, const struct weft_marks *complete,
                        const struct weft_marks *visible, struct counts *counts)
{
    for (int p = 0; p < PIXELS; p++) {
        const bool mixed = truth->mixed[p], neighbours = has_neighbours(truth->surface, p);
        assert_true(complete->marked[p] >= visible->marked[p]);
        counts->mixed += mixed;
        counts->complete += complete->marked[p];
        counts->visible += visible->marked[p];
        counts->neighbours += neighbours;
        counts->missed += mixed && !complete->marked[p];
        counts->missed_visible += mixed && !visible->marked[p];
        counts->missed_neighbours += mixed && !neighbours;
        if (mixed && !complete->marked[p])
            print_error("(%d, %d) is missed\n", p % SIZE, p / SIZE);
    }
}

static void mark_scene(weft_marker *complete, weft_marker *visible, enum kind kind, int triangles,
                       uint64_t seed, struct counts *counts)
{
    static struct triangle_vertex vertices[6 * MOST];
    static struct truth truth;
    struct triangles scene;
    struct weft_marks marks[2];
    const int n = make_scene(kind, triangles, seed, vertices);
    triangles_create(complete->params.context, vertices, n, &scene);
    assert_int_equal(weft_marker_run(complete, triangles_drawing(&scene), &marks[0]), WEFT_OK);
    assert_int_equal(weft_marker_run(visible, triangles_drawing(&scene), &marks[1]), WEFT_OK);
    find_truth(complete, &scene, &truth);
    count_marks(&truth, &marks[0], &marks[1], counts);
    weft_marks_clear(&marks[0]);
    weft_marks_clear(&marks[1]);
    triangles_destroy(&scene);
}

static double percent(int64_t pixels, int scenes)
{
    return 100.0 * (double)pixels / PIXELS / scenes;
}

// Complete marks have all visible ones; visible ones and surfaces alone do miss some.
static void no_mixed_pixel_is_missed(void **state)
{
    (void)state;
    static const int triangles[] = {30, 200, MOST};
    const char *text = getenv("WEFT_MARKS_SCENES");
    const int scenes = text ? atoi(text) : 1;
    weft_marker *complete = create((struct weft_marker_params){.mark = WEFT_MARK_COMPLETE}),
                *visible = create((struct weft_marker_params){.mark = WEFT_MARK_VISIBLE});
    struct counts sum = {0};
    for (int kind = 0; kind < KINDS; kind++)
        for (size_t t = 0; t < WEFT_COUNT(triangles); t++) {
            struct counts counts = {0};
            if (!text && t != (size_t)kind % 3 && t != 1)
                continue;
            for (int i = 0; i < scenes; i++)
                mark_scene(complete, visible, kind, triangles[t],
                           (uint64_t)(1000 * i + 10 * kind) + t, &counts);
            print_message(
                "%-11s %4d triangles: %4.1f %% mixed, marked %4.1f %%, visible %4.1f %%\n",
                kind_names[kind], triangles[t], percent(counts.mixed, scenes),
                percent(counts.complete, scenes), percent(counts.visible, scenes));
            assert_true(counts.mixed > 0);
            assert_int_equal(counts.missed, 0);
            sum.mixed += counts.mixed;
            sum.missed_visible += counts.missed_visible;
            sum.missed_neighbours += counts.missed_neighbours;
        }
    print_message("of %lld mixed pixels visible marks miss %lld, 3 x 3 surfaces alone %lld\n",
                  (long long)sum.mixed, (long long)sum.missed_visible,
                  (long long)sum.missed_neighbours);
    assert_true(sum.missed_neighbours > 0);
    weft_marker_destroy(&complete);
    weft_marker_destroy(&visible);
}

static void other_contexts_and_thin_lines_miss_none(void **state)
{
    (void)state;
    for (int c = 0; c < 2 && contexts[c]; c++) {
        struct counts counts = {0};
        weft_marker *complete = create((struct weft_marker_params){.context = contexts[c]}),
                    *visible = create((struct weft_marker_params){.mark = WEFT_MARK_VISIBLE,
                                                                  .context = contexts[c]});
        if (c == 0) // as if GL had no wide ones
            complete->line_width = complete->point_size = visible->line_width =
                visible->point_size = 1.0f;
        mark_scene(complete, visible, c == 0 ? SIZES : STEEP, 150, 77, &counts);
        assert_true(counts.mixed > 0);
        assert_int_equal(counts.missed, 0);
        weft_marker_destroy(&complete);
        weft_marker_destroy(&visible);
    }
}

// ---- lines of the application's own -------------------------------------------------------------

static GLuint line_buffer;
static int line_indices;

static void draw_lines(const GladGLContext *gl, const struct weft_antialias_pass *pass)
{
    if (pass->stage < WEFT_STAGE_LINES)
        return;
    gl->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, line_buffer);
    gl->DrawElements(pass->stage == WEFT_STAGE_LINES ? GL_LINES : GL_POINTS, line_indices,
                     GL_UNSIGNED_INT, NULL);
}

// Its triangles are left out where lines are drawn.
static enum weft_result draw_with_lines(void *priv, const struct weft_antialias_pass *pass)
{
    struct triangles *scene = priv;
    scene->count = pass->stage < WEFT_STAGE_LINES ? 0 : 1; // one vertex is no triangle
    return triangles_draw(scene, pass);
}

// Squares of two triangles, which touch and lie above one another, level and upright or turned.
static int make_squares(struct triangle_vertex *out, uint32_t *lines, int squares)
{
    static const int corners[6] = {0, 1, 2, 2, 1, 3}, outline[8] = {0, 1, 1, 5, 5, 2, 2, 0};
    random_state = 5;
    for (int s = 0; s < squares; s++) {
        const double x = between(0.0, SIZE), y = between(0.0, SIZE), size = between(1.0, 24.0);
        const double angle = s % 3 ? between(0.0, 1.5) : 0.0, depth = between(0.1, 0.9);
        for (int t = 0; t < 2; t++) {
            double corner[3][2];
            for (int k = 0; k < 3; k++) {
                const double u = size * (corners[3 * t + k] % 2),
                             v = size * (corners[3 * t + k] / 2);
                corner[k][0] = x + u * cos(angle) - v * sin(angle);
                corner[k][1] = y + u * sin(angle) + v * cos(angle);
            }
            triangle_at((const int[2]){SIZE, SIZE}, corner, depth,
                        (const float[4]){(float)uniform(), 1.0f, 1.0f, 1.0f}, (uint32_t)s + 1,
                        out + 6 * s + 3 * t);
        }
        for (int k = 0; k < 8; k++)
            lines[8 * s + k] = (uint32_t)(6 * s + outline[k]);
    }
    return 6 * squares;
}

// Marks by such lines miss nothing; returns how many there are beside those by triangles.
static int64_t check_lines(const struct triangle_vertex *vertices, int count, const uint32_t *lines,
                           int indices)
{
    static struct truth truth;
    struct triangles scene;
    struct weft_marks marks, triangles;
    int64_t mixed = 0;
    weft_marker *m = create((struct weft_marker_params){0});
    const GladGLContext *gl = &contexts[0]->gl;
    triangles_create(contexts[0], vertices, count, &scene);
    assert_int_equal(weft_marker_run(m, triangles_drawing(&scene), &triangles), WEFT_OK);
    assert_int_equal(weft_context_enter(contexts[0]), WEFT_OK);
    gl->GenBuffers(1, &line_buffer);
    gl->BindBuffer(GL_ARRAY_BUFFER, line_buffer);
    gl->BufferData(GL_ARRAY_BUFFER, indices * (GLsizeiptr)sizeof *lines, lines, GL_STATIC_DRAW);
    weft_context_leave(contexts[0]);
    line_indices = indices;
    scene.before = draw_lines;
    const struct weft_antialias_drawing drawing = {.draw = draw_with_lines, .priv = &scene};
    assert_int_equal(weft_marker_run(m, &drawing, &marks), WEFT_OK);
    scene.count = 0;
    find_truth(m, &scene, &truth);
    for (int p = 0; p < PIXELS; p++) {
        mixed += truth.mixed[p];
        assert_true(marks.marked[p] >= truth.mixed[p]);
    }
    assert_true(mixed > 0);
    const int64_t more = marks.count - triangles.count;
    weft_marks_clear(&marks);
    weft_marks_clear(&triangles);
    triangles_destroy(&scene);
    weft_marker_destroy(&m);
    return more;
}

static void lines_of_surfaces_are_enough(void **state)
{
    (void)state;
    enum { SQUARES = 60, STEEP_ONES = 150 };
    static struct triangle_vertex vertices[3 * STEEP_ONES + 6 * SQUARES];
    static uint32_t lines[6 * STEEP_ONES + 8 * SQUARES];
    const int squares = make_squares(vertices, lines, SQUARES);
    assert_true(check_lines(vertices, squares, lines, 8 * SQUARES) < 0); // no diagonals
    const int steep = make_scene(STEEP, STEEP_ONES, 4, vertices);
    for (int i = 0; i < steep; i++) {
        lines[2 * i] = (uint32_t)i;
        lines[2 * i + 1] = (uint32_t)(i % 3 == 2 ? i - 2 : i + 1);
    }
    assert_true(check_lines(vertices, steep, lines, 2 * steep) < 0); // no slopes
}

// ---- contrast -----------------------------------------------------------------------------------

// Squares of 4 x 4 pixels that fill the picture, of one surface, without lines: only contrast is
// there to be found.
static enum weft_result draw_without_lines(void *priv, const struct weft_antialias_pass *pass)
{
    return pass->stage < WEFT_STAGE_LINES ? triangles_draw(priv, pass) : WEFT_OK;
}

enum { TILE = 4, TILES = SIZE / TILE };

static void create_tiles(float (*value)(int x, int y), struct triangles *scene)
{
    static struct triangle_vertex vertices[6 * TILES * TILES];
    for (int i = 0; i < TILES * TILES; i++)
        for (int t = 0; t < 2; t++) {
            const int x = i % TILES, y = i / TILES;
            const double low[2] = {x * TILE, y * TILE}, high[2] = {low[0] + TILE, low[1] + TILE};
            const double corner[3][2] = {
                {low[0], high[1]}, {high[0], low[1]}, {t ? high[0] : low[0], t ? high[1] : low[1]}};
            triangle_at((const int[2]){SIZE, SIZE}, corner, 0.5,
                        (const float[4]){value(x, y), 0.5f, 0.5f, 1.0f}, 1,
                        vertices + 6 * i + 3 * t);
        }
    triangles_create(contexts[0], vertices, 6 * TILES * TILES, scene);
}

// As the header has it, in plain words.
static double contrast_at(const float *picture, int p)
{
    double largest = 0.0;
    for (int y = p / SIZE - 1; y <= p / SIZE + 1; y++)
        for (int x = p % SIZE - 1; x <= p % SIZE + 1; x++) {
            if (x < 0 || y < 0 || x >= SIZE || y >= SIZE)
                continue;
            const float a = picture[p], b = picture[y * SIZE + x];
            if (isnan(a) && isnan(b))
                continue;
            const double d = a == b ? 0.0 : (double)fabsf(a - b);
            largest = fmax(largest, isnan(d) ? (double)INFINITY : d);
        }
    return largest;
}

static float random_value(int x, int y)
{
    (void)x;
    (void)y;
    return (float)uniform();
}

static float bad_value(int x, int y)
{
    static const float values[] = {0.25f, NAN, INFINITY, 0.5f, -INFINITY, NAN, 1e38f, -1e38f};
    return values[(x + 3 * y) % 8];
}

// 4 x 4 pixels with 2 values: many differences are the same.
static float step_value(int x, int y)
{
    return x < TILES / 2 ? 0.25f * (float)(y / 4) : 1.0f;
}

struct contrast_case {
    float (*value)(int x, int y);
    double contrast, share;
    enum weft_antialias_format format;
};

static void check_contrast(const struct contrast_case *c)
{
    static float picture[PIXELS];
    struct triangles scene;
    struct weft_marks marks;
    double squares = 0.0, least = (double)INFINITY, most_left = 0.0;
    int64_t found = 0, kept = 0, last_kept = -1, first_left = PIXELS;
    weft_marker *m = create((struct weft_marker_params){
        .format = c->format, .contrast = c->contrast, .max_share = c->share});
    random_state = 3;
    create_tiles(c->value, &scene);
    const struct weft_antialias_drawing drawing = {.draw = draw_without_lines, .priv = &scene};
    assert_int_equal(weft_marker_run(m, &drawing, &marks), WEFT_OK);
    assert_int_equal(weft_marker_read(m, 0, picture, 0), WEFT_OK);
    const int64_t rim = marks.by_edges; // of one surface only the rim is marked
    assert_int_equal(rim, 4 * (SIZE - 1));
    for (int p = 0; p < PIXELS; p++) {
        const bool at_rim = p < SIZE || p >= PIXELS - SIZE || p % SIZE == 0 || p % SIZE == SIZE - 1;
        const double d = contrast_at(picture, p);
        if (!at_rim && !(d > c->contrast)) {
            assert_int_equal(marks.marked[p], 0);
            continue;
        }
        found++;
        if (marks.marked[p]) {
            kept++;
            last_kept = d < least || (d == least && p > last_kept) ? p : last_kept;
            least = fmin(least, d);
        } else {
            squares += d * d;
            first_left = d > most_left || (d == most_left && p < first_left) ? p : first_left;
            most_left = fmax(most_left, d);
        }
    }
    assert_int_equal(marks.count, kept);
    assert_int_equal(marks.by_contrast, found - rim);
    assert_int_equal(marks.left, found - kept);
    assert_true(found > rim);
    if (c->share > 0.0) {
        assert_int_equal(kept, (int64_t)floor(c->share * PIXELS));
        assert_true(most_left < least || (most_left == least && first_left > last_kept));
    } else {
        assert_int_equal(marks.left, 0);
    }
    const double error = sqrt(squares / 12.0 / PIXELS);
    assert_true(marks.left_error == error || fabs(marks.left_error / error - 1.0) < 1e-12);
    weft_marks_clear(&marks);
    triangles_destroy(&scene);
    weft_marker_destroy(&m);
}

static void contrast_is_found_and_ranked(void **state)
{
    (void)state;
    static const struct contrast_case cases[] = {
        {random_value, 0.25, 0.0, WEFT_ANTIALIAS_RGBA32F},
        {random_value, 0.25, 0.3, WEFT_ANTIALIAS_RGBA32F},
        {random_value, 0.1, 0.05, WEFT_ANTIALIAS_RGBA16F},
        {random_value, 0.5, 0.1, WEFT_ANTIALIAS_RGBA8},
        {step_value, 0.2, 0.11, WEFT_ANTIALIAS_RGBA8},
        {step_value, 0.3, 0.0, WEFT_ANTIALIAS_RGBA16F},
        {bad_value, 0.1, 0.0, WEFT_ANTIALIAS_RGBA32F},
        {bad_value, 0.1, 0.4, WEFT_ANTIALIAS_RGBA32F},
    };
    for (size_t i = 0; i < WEFT_COUNT(cases); i++)
        check_contrast(&cases[i]);
}

// What is left is estimated within a factor of 2 of what it is on a scene of plain triangles.
static void the_estimate_of_what_is_left_is_near(void **state)
{
    (void)state;
    static struct triangle_vertex vertices[6 * MOST];
    static struct truth truth;
    static float picture[3][PIXELS];
    for (int share = 5; share <= 25; share += 10) {
        struct triangles scene;
        struct weft_marks marks, all;
        double squares = 0.0;
        weft_marker *m = create((struct weft_marker_params){.max_share = 0.01 * share}),
                    *unlimited = create((struct weft_marker_params){0});
        triangles_create(contexts[0], vertices, make_scene(SIZES, 200, 11, vertices), &scene);
        assert_int_equal(weft_marker_run(m, triangles_drawing(&scene), &marks), WEFT_OK);
        assert_int_equal(weft_marker_run(unlimited, triangles_drawing(&scene), &all), WEFT_OK);
        for (int c = 0; c < 3; c++)
            assert_int_equal(weft_marker_read(m, c, picture[c], 0), WEFT_OK);
        find_truth(m, &scene, &truth);
        for (int p = 0; p < PIXELS; p++) {
            double error = 0.0;
            for (int c = 0; c < 3; c++)
                error = fmax(error, fabs((double)(truth.mean[p][c] - picture[c][p])));
            if (all.marked[p] && !marks.marked[p])
                squares += error * error;
        }
        const double is = sqrt(squares / PIXELS);
        print_message("%d %% of pixels marked, %lld left: off by %.4f, estimated %.4f\n", share,
                      (long long)marks.left, is, marks.left_error);
        assert_int_equal(marks.count + marks.left, all.count);
        assert_true(is > 0.5 * marks.left_error && is < 2.0 * marks.left_error);
        weft_marks_clear(&marks);
        weft_marks_clear(&all);
        triangles_destroy(&scene);
        weft_marker_destroy(&m);
        weft_marker_destroy(&unlimited);
    }
}

// ---- wider marks --------------------------------------------------------------------------------

static void check_dilation(int width, int height, int radius, double share)
{
    const int pixels = width * height;
    uint8_t *before = malloc((size_t)pixels);
    struct weft_marks marks = {
        .width = width, .height = height, .marked = malloc((size_t)pixels), .by_edges = 5};
    int64_t count = 0;
    assert_true(before && marks.marked);
    for (int i = 0; i < pixels; i++) {
        before[i] = marks.marked[i] = uniform() < share;
        marks.count += before[i];
    }
    assert_int_equal(weft_marks_dilate(&marks, radius), WEFT_OK);
    for (int i = 0; i < pixels; i++) {
        bool near = false;
        for (int y = i / width - radius; y <= i / width + radius; y++)
            for (int x = i % width - radius; x <= i % width + radius; x++)
                if (x >= 0 && y >= 0 && x < width && y < height)
                    near = near || before[y * width + x];
        assert_int_equal(marks.marked[i], near);
        count += near;
    }
    assert_int_equal(marks.count, count);
    assert_int_equal(marks.by_edges, 5);
    free(before);
    weft_marks_clear(&marks);
    assert_null(marks.marked);
}

static void marks_are_dilated(void **state)
{
    (void)state;
    random_state = 9;
    for (int radius = 0; radius <= 5; radius++) {
        check_dilation(23, 17, radius, 0.02);
        check_dilation(3, 40, radius, 0.1);
        check_dilation(1, 1, radius, 0.5);
    }
    check_dilation(90, 7, WEFT_MARKS_MAX_RADIUS, 0.002);
    check_dilation(20, 20, 2, 0.0);
    check_dilation(20, 20, 2, 1.0);
}

// ---- what goes wrong ----------------------------------------------------------------------------

static void failures_leave_nothing(void **state)
{
    (void)state;
    static struct triangle_vertex vertices[6 * 30];
    float out[PIXELS];
    struct triangles scene;
    struct weft_marks marks;
    struct message message = {0};
    const struct weft_log log = {keep_message, &message};
    weft_marker *m = NULL;
    assert_int_equal(weft_marker_create(weft_marker_params(.width = 1 << 20, .height = 4,
                                                           .context = contexts[0], .log = &log),
                                        &m),
                     WEFT_ERR_LIMIT);
    assert_null(m);
    assert_non_null(strstr(message.text, "1048576"));
    m = create((struct weft_marker_params){.background = {0.25, 0.5, 0.75, 1.0}});
    m->params.log = &log;
    assert_int_equal(weft_marker_read(m, 0, out, 0), WEFT_ERR_ARGUMENT);
    triangles_create(contexts[0], vertices, make_scene(SIZES, 30, 2, vertices), &scene);
    scene.result = WEFT_ERR_CANCELLED;
    assert_int_equal(weft_marker_run(m, triangles_drawing(&scene), &marks), WEFT_ERR_CANCELLED);
    assert_true(!marks.marked && marks.width == 0 && marks.count == 0);
    assert_int_equal(weft_marker_read(m, 0, out, 0), WEFT_ERR_ARGUMENT);
    scene.result = WEFT_OK;
    assert_int_equal(weft_marker_run(m, triangles_drawing(&scene), &marks), WEFT_OK);
    assert_int_equal(weft_marker_read(m, 2, out, 0), WEFT_OK);
    assert_float_equal(out[0], 191.0f / 255.0f, 0.0); // nobody is there
    assert_int_equal(weft_marks_dilate(&marks, -1), WEFT_ERR_ARGUMENT);
    assert_int_equal(weft_marks_dilate(&marks, WEFT_MARKS_MAX_RADIUS + 1), WEFT_ERR_ARGUMENT);
    weft_marks_clear(&marks);
    assert_int_equal(weft_marks_dilate(&marks, 1), WEFT_ERR_ARGUMENT);
    triangles_destroy(&scene);
    weft_marker_destroy(&m);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_mixed_pixel_is_missed),
        cmocka_unit_test(other_contexts_and_thin_lines_miss_none),
        cmocka_unit_test(lines_of_surfaces_are_enough),
        cmocka_unit_test(contrast_is_found_and_ranked),
        cmocka_unit_test(the_estimate_of_what_is_left_is_near),
        cmocka_unit_test(marks_are_dilated),
        cmocka_unit_test(failures_leave_nothing),
    };
    return cmocka_run_group_tests(tests, create_contexts, destroy_contexts);
}
