// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/mesh/soup.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <assimp/material.h>
#include <assimp/scene.h>

#include "filter/check.h"
#include "tiles/readers/mesh/polygon.h"

enum {
    DEPTH_LIMIT = 1000, // of nodes below each other
    INDEX_LIMIT = 3 * WEFT_MESH_MAX_TRIANGLES,
};

// Three rows of a matrix whose fourth is (0, 0, 0, 1).
struct transform {
    double m[3][4];
};

struct maker {
    const struct aiScene *scene;
    struct weft_mesh_source *source;
    struct weft_mesh_soup *soup;
    uint32_t *material; // of each of the scene's: its place + 1 in the soup's list
    uint32_t object;
};

#define fail(m, result, ...) weft_mesh_fail((m)->source, result, __VA_ARGS__)

// ---- names --------------------------------------------------------------------------------------

// UTF-8, cut where a character begins.
static void copy_name(char out[WEFT_MESH_NAME], const char *text)
{
    size_t length = strlen(text);
    if (length >= WEFT_MESH_NAME)
        for (length = WEFT_MESH_NAME - 1; length && ((unsigned char)text[length] & 0xc0) == 0x80;)
            length--;
    memcpy(out, text, length);
    memset(out + length, 0, WEFT_MESH_NAME - length);
}

// assimp makes up names of what has none.
static bool made_up(const char *name)
{
    return !strcmp(name, "defaultobject") || !strcmp(name, AI_DEFAULT_MATERIAL_NAME) ||
           !strncmp(name, "nodes[", 6);
}

static void name_part(const struct maker *m, const struct aiNode *node, char out[WEFT_MESH_NAME])
{
    copy_name(out, node->mName.data);
    if (!*out || m->source->kind == WEFT_MESH_PLY || made_up(out))
        snprintf(out, WEFT_MESH_NAME, "part %zu", m->soup->part_count + 1);
}

// ---- materials ----------------------------------------------------------------------------------

static bool colour_of(const struct aiMaterial *material, const char *key, float out[3])
{
    struct aiColor4D colour;
    if (aiGetMaterialColor(material, key, 0, 0, &colour) != aiReturn_SUCCESS)
        return false;
    memcpy(out, (float[3]){colour.r, colour.g, colour.b}, 3 * sizeof *out);
    return true;
}

static float limited(float value, float most)
{
    return value < 0.0f ? 0.0f : value > most ? most : value;
}

static enum weft_result take_material(struct maker *m, const struct aiMaterial *from,
                                      struct weft_mesh_material *to)
{
    struct aiString name;
    for (int c = 0; c < 3; c++)
        to->reflectance[c] = WEFT_MESH_REFLECTANCE;
    if (aiGetMaterialString(from, AI_MATKEY_NAME, &name) == aiReturn_SUCCESS)
        copy_name(to->name, name.data);
    const bool none = made_up(to->name), obj = m->source->kind == WEFT_MESH_OBJ;
    if (none || m->source->kind == WEFT_MESH_PLY)
        *to->name = '\0';
    // What assimp makes up does not count.
    if (m->source->kind == WEFT_MESH_PLY || (obj && (none || !m->source->files->opened)))
        return WEFT_OK;
    colour_of(from, "$clr.diffuse", to->reflectance);
    colour_of(from, "$clr.base", to->reflectance);
    colour_of(from, "$clr.emissive", to->emission);
    for (int c = 0; c < 3; c++) {
        if (!isfinite(to->reflectance[c]) || !isfinite(to->emission[c]))
            return fail(m, WEFT_ERR_FORMAT, "the material '%s' has a colour that is not finite",
                        to->name);
        to->reflectance[c] = limited(to->reflectance[c], 1.0f);
        to->emission[c] = limited(to->emission[c], WEFT_MESH_LARGEST);
    }
    return WEFT_OK;
}

// Those that triangles are made of, in the order of their first use.
static enum weft_result use_material(struct maker *m, unsigned which, uint32_t *out)
{
    struct weft_mesh_soup *soup = m->soup;
    if (which >= m->scene->mNumMaterials)
        return fail(m, WEFT_ERR_FORMAT, "there is no material %u: it has %u", which,
                    m->scene->mNumMaterials);
    enum weft_result res = WEFT_OK;
    if (!m->material[which]) {
        res = take_material(m, m->scene->mMaterials[which], &soup->materials[soup->material_count]);
        m->material[which] = (uint32_t)++soup->material_count;
    }
    *out = m->material[which] - 1;
    return res;
}

// ---- transforms ---------------------------------------------------------------------------------

static struct transform transform_of(const struct aiMatrix4x4 *a)
{
    return (struct transform){
        {{a->a1, a->a2, a->a3, a->a4}, {a->b1, a->b2, a->b3, a->b4}, {a->c1, a->c2, a->c3, a->c4}}};
}

static struct transform product(const struct transform *a, const struct transform *b)
{
    struct transform out;
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 4; c++)
            out.m[r][c] = a->m[r][0] * b->m[0][c] + a->m[r][1] * b->m[1][c] +
                          a->m[r][2] * b->m[2][c] + (c == 3 ? a->m[r][3] : 0.0);
    return out;
}

// What normals are multiplied with: the cofactors, which are the inverse's transpose times the
// determinant. Returns the determinant.
static double cofactors(const struct transform *t, double out[3][3])
{
    for (int r = 0; r < 3; r++)
        for (int c = 0; c < 3; c++) {
            const int r1 = (r + 1) % 3, r2 = (r + 2) % 3, c1 = (c + 1) % 3, c2 = (c + 2) % 3;
            out[r][c] = t->m[r1][c1] * t->m[r2][c2] - t->m[r1][c2] * t->m[r2][c1];
        }
    return t->m[0][0] * out[0][0] + t->m[0][1] * out[0][1] + t->m[0][2] * out[0][2];
}

// ---- vertices -----------------------------------------------------------------------------------

// Colours of OBJ and PLY files are those of a picture: sRGB (IEC 61966-2-1).
static float linear(float v)
{
    return v <= 0.04045f ? v / 12.92f : (float)pow(((double)v + 0.055) / 1.055, 2.4);
}

static bool all_finite(const float *values, int count)
{
    for (int i = 0; i < count; i++)
        if (!(fabsf(values[i]) <= WEFT_MESH_LARGEST))
            return false;
    return true;
}

// 0 where it has no direction; 1e30 and 1e-30 squared are numbers, in double.
static void set_normal(float out[3], const double n[3], double sign)
{
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int c = 0; c < 3; c++)
        out[c] = length > 0.0 && isfinite(length) ? (float)(sign * n[c] / length) + 0.0f : 0.0f;
}

static void take_colour(const struct maker *m, const struct aiColor4D *from, float out[3])
{
    memcpy(out, (float[3]){from->r, from->g, from->b}, 3 * sizeof *out);
    for (int c = 0; c < 3 && all_finite(out, 3); c++) {
        out[c] = limited(out[c], 1.0f);
        if (m->source->kind == WEFT_MESH_OBJ || m->source->kind == WEFT_MESH_PLY)
            out[c] = linear(out[c]);
    }
}

struct placing {
    struct transform world;
    double normal[3][3], sign;
};

static void take_vertex(const struct maker *m, const struct aiMesh *mesh, unsigned v,
                        const struct placing *place, struct weft_mesh_vertex *out)
{
    const struct aiVector3D *p = &mesh->mVertices[v];
    for (int c = 0; c < 3; c++) {
        const double *row = place->world.m[c];
        out->position[c] = (float)(row[0] * p->x + row[1] * p->y + row[2] * p->z + row[3]) + 0.0f;
        out->colour[c] = 1.0f;
    }
    if (mesh->mNormals) {
        const struct aiVector3D *n = &mesh->mNormals[v];
        double turned[3];
        for (int c = 0; c < 3; c++)
            turned[c] = place->normal[c][0] * n->x + place->normal[c][1] * n->y +
                        place->normal[c][2] * n->z;
        set_normal(out->normal, turned, place->sign);
    }
    if (mesh->mTextureCoords[0]) {
        out->uv[0] = mesh->mTextureCoords[0][v].x + 0.0f;
        out->uv[1] = mesh->mTextureCoords[0][v].y + 0.0f;
    }
    if (mesh->mColors[0])
        take_colour(m, &mesh->mColors[0][v], out->colour);
}

static enum weft_result check_vertex(struct maker *m, const struct aiMesh *mesh, unsigned v,
                                     const struct weft_mesh_vertex *vertex, const char *part)
{
    const struct aiVector3D *n = mesh->mNormals ? &mesh->mNormals[v] : NULL;
    if (!all_finite(vertex->position, 3))
        return fail(m, WEFT_ERR_FORMAT,
                    "vertex %u of '%s' lies at (%g, %g, %g): finite numbers up to 1e30 are due", v,
                    part, (double)vertex->position[0], (double)vertex->position[1],
                    (double)vertex->position[2]);
    if (n && !all_finite((float[3]){n->x, n->y, n->z}, 3))
        return fail(m, WEFT_ERR_FORMAT,
                    "vertex %u of '%s' has the normal (%g, %g, %g): finite numbers are due", v,
                    part, (double)n->x, (double)n->y, (double)n->z);
    if (!all_finite(vertex->uv, 2) || !all_finite(vertex->colour, 3))
        return fail(m, WEFT_ERR_FORMAT,
                    "vertex %u of '%s' has a colour or texture coordinates that are not finite", v,
                    part);
    return WEFT_OK;
}

// ---- parts --------------------------------------------------------------------------------------

static void take_triangle(struct weft_mesh_soup *soup, const struct aiFace *face,
                          const int corners[3], bool mirrored)
{
    // Mirrored triangles are seen from the other side.
    const int order[3] = {corners[0], corners[mirrored ? 2 : 1], corners[mirrored ? 1 : 2]};
    for (int i = 0; i < 3; i++)
        soup->indices[soup->index_count++] =
            (uint32_t)soup->vertex_count + face->mIndices[order[i]];
}

// A polygon of three corners or more, cut where the file has it.
static void take_polygon(struct weft_mesh_soup *soup, const struct aiMesh *mesh,
                         const struct aiFace *face, bool mirrored)
{
    float corners[WEFT_MESH_CORNERS][3];
    int triangles[WEFT_MESH_CORNERS][3] = {{0, 1, 2}};
    const int count = (int)face->mNumIndices;
    for (int i = 0; i < count; i++) {
        const struct aiVector3D *p = &mesh->mVertices[face->mIndices[i]];
        memcpy(corners[i], (float[3]){p->x, p->y, p->z}, sizeof corners[i]);
    }
    weft_mesh_cut(corners, count, triangles);
    for (int t = 0; t < count - 2; t++)
        take_triangle(soup, face, triangles[t], mirrored);
}

static enum weft_result take_faces(struct maker *m, const struct aiMesh *mesh, double sign,
                                   const char *part)
{
    static const int whole[3] = {0, 1, 2};
    for (unsigned f = 0; f < mesh->mNumFaces; f++) {
        const struct aiFace *face = &mesh->mFaces[f];
        if (!face->mNumIndices)
            return fail(m, WEFT_ERR_FORMAT, "face %u of '%s' has no corners", f, part);
        for (unsigned i = 0; i < face->mNumIndices; i++)
            if (face->mIndices[i] >= mesh->mNumVertices)
                return fail(m, WEFT_ERR_FORMAT, "face %u of '%s' has the index %u of %u vertices",
                            f, part, face->mIndices[i], mesh->mNumVertices);
        if (face->mNumIndices == 3)
            take_triangle(m->soup, face, whole, sign < 0.0);
        else if (face->mNumIndices > 3)
            take_polygon(m->soup, mesh, face, sign < 0.0);
    }
    return WEFT_OK;
}

static enum weft_result take_mesh(struct maker *m, const struct aiNode *node,
                                  const struct aiMesh *mesh, const struct placing *place)
{
    struct weft_mesh_soup *soup = m->soup;
    struct weft_mesh_part *part = &soup->parts[soup->part_count];
    part->first_index = (uint32_t)soup->index_count;
    name_part(m, node, part->name);
    enum weft_result res = take_faces(m, mesh, place->sign, part->name);
    part->index_count = (uint32_t)soup->index_count - part->first_index;
    if (res == WEFT_OK && part->index_count)
        res = use_material(m, mesh->mMaterialIndex, &part->material);
    if (res != WEFT_OK || !part->index_count)
        return res;
    soup->part_count++;
    for (unsigned v = 0; res == WEFT_OK && v < mesh->mNumVertices; v++) {
        struct weft_mesh_vertex *vertex = &soup->vertices[soup->vertex_count];
        soup->objects[soup->vertex_count++] = m->object;
        take_vertex(m, mesh, v, place, vertex);
        res = check_vertex(m, mesh, v, vertex, part->name);
    }
    return res;
}

// ---- nodes --------------------------------------------------------------------------------------

struct totals {
    uint64_t vertices, indices, parts;
    uint64_t lines, points, skins, morphs;
    unsigned largest; // corners of a polygon
};

static void count_faces(const struct aiMesh *mesh, struct totals *t)
{
    const uint64_t before = t->indices;
    for (unsigned f = 0; f < mesh->mNumFaces; f++) {
        const unsigned n = mesh->mFaces[f].mNumIndices;
        t->indices += n >= 3 ? 3 * (uint64_t)(n - 2) : 0;
        t->lines += n == 2;
        t->points += n == 1;
        t->largest = n > t->largest ? n : t->largest;
    }
    t->points += !mesh->mNumFaces ? mesh->mNumVertices : 0;
    t->skins += mesh->mNumBones > 0;
    t->morphs += mesh->mNumAnimMeshes;
    if (t->indices == before)
        return;
    t->vertices += mesh->mNumVertices;
    t->parts++;
}

static enum weft_result count_nodes(struct maker *m, const struct aiNode *node, int depth,
                                    struct totals *t)
{
    if (depth > DEPTH_LIMIT)
        return fail(m, WEFT_ERR_LIMIT, "its nodes lie more than %d deep", DEPTH_LIMIT);
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        if (node->mMeshes[i] >= m->scene->mNumMeshes)
            return fail(m, WEFT_ERR_FORMAT, "there is no mesh %u: it has %u", node->mMeshes[i],
                        m->scene->mNumMeshes);
        count_faces(m->scene->mMeshes[node->mMeshes[i]], t);
        if (t->indices > INDEX_LIMIT || t->vertices > INT32_MAX || t->parts > WEFT_MESH_MAX_PARTS)
            return fail(m, WEFT_ERR_LIMIT,
                        "it has at least %" PRIu64 " triangles, %" PRIu64 " vertices and %" PRIu64
                        " parts: %d, %d and %d are the limits",
                        t->indices / 3, t->vertices, t->parts, WEFT_MESH_MAX_TRIANGLES, INT32_MAX,
                        WEFT_MESH_MAX_PARTS);
    }
    enum weft_result res = WEFT_OK;
    for (unsigned i = 0; res == WEFT_OK && i < node->mNumChildren; i++)
        res = count_nodes(m, node->mChildren[i], depth + 1, t);
    return res;
}

static enum weft_result take_nodes(struct maker *m, const struct aiNode *node,
                                   const struct transform *above)
{
    struct placing place;
    const struct transform own = transform_of(&node->mTransformation);
    place.world = product(above, &own);
    place.sign = cofactors(&place.world, place.normal) < 0.0 ? -1.0 : 1.0;
    enum weft_result res = WEFT_OK;
    m->object++;
    for (unsigned i = 0; res == WEFT_OK && i < node->mNumMeshes; i++)
        res = take_mesh(m, node, m->scene->mMeshes[node->mMeshes[i]], &place);
    for (unsigned i = 0; res == WEFT_OK && i < node->mNumChildren; i++)
        res = take_nodes(m, node->mChildren[i], &place.world);
    return res;
}

// ---- what is left out ---------------------------------------------------------------------------

static void drop(char *text, uint64_t count, const char *what)
{
    const size_t used = strlen(text);
    if (count)
        snprintf(text + used, WEFT_MESH_DROPPED - used, "%s%" PRIu64 " %s%s", used ? ", " : "",
                 count, what, count == 1 ? "" : "s");
}

static uint64_t count_textures(const struct aiScene *scene)
{
    uint64_t textures = 0;
    for (unsigned i = 0; i < scene->mNumMaterials; i++)
        for (int type = 0; type <= AI_TEXTURE_TYPE_MAX; type++)
            textures += aiGetMaterialTextureCount(scene->mMaterials[i], (enum aiTextureType)type);
    return textures;
}

static void say_left(const struct maker *m, const struct totals *t, char *text)
{
    drop(text, t->lines, "line");
    drop(text, t->points, "point");
    drop(text, count_textures(m->scene), "texture");
    drop(text, m->source->strengths, "emissive strength");
    drop(text, m->scene->mNumAnimations, "animation");
    drop(text, t->skins, "skin");
    drop(text, t->morphs, "morph target");
    drop(text, m->scene->mNumCameras, "camera");
    drop(text, m->scene->mNumLights, "light");
}

// ---- all of it ----------------------------------------------------------------------------------

static bool allocate(struct maker *m, const struct totals *t)
{
    struct weft_mesh_soup *soup = m->soup;
    const unsigned materials = m->scene->mNumMaterials;
    soup->vertices = calloc(t->vertices, sizeof *soup->vertices);
    soup->objects = calloc(t->vertices, sizeof *soup->objects);
    soup->indices = calloc(t->indices, sizeof *soup->indices);
    soup->parts = calloc(t->parts + 1, sizeof *soup->parts); // one for lines, which then goes
    soup->materials = calloc((size_t)materials + 1, sizeof *soup->materials);
    m->material = calloc((size_t)materials + 1, sizeof *m->material);
    return soup->vertices && soup->objects && soup->indices && soup->parts && soup->materials &&
           m->material;
}

enum weft_result weft_mesh_soup_make(const struct aiScene *scene, struct weft_mesh_source *source,
                                     struct weft_mesh_soup *out)
{
    static const struct transform none = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    struct maker m = {.scene = scene, .source = source, .soup = out};
    struct totals totals = {0};
    *out = (struct weft_mesh_soup){0};
    enum weft_result res =
        scene->mRootNode ? count_nodes(&m, scene->mRootNode, 0, &totals) : WEFT_OK;
    if (res == WEFT_OK && totals.largest > WEFT_MESH_CORNERS)
        res = fail(&m, WEFT_ERR_LIMIT, "a polygon has %u corners: %d is the limit", totals.largest,
                   WEFT_MESH_CORNERS);
    say_left(&m, &totals, out->dropped);
    if (res == WEFT_OK && !totals.indices)
        res = fail(&m, WEFT_ERR_FORMAT, "it has no triangles%s%s", *out->dropped ? ", but " : "",
                   out->dropped);
    if (res == WEFT_OK && !allocate(&m, &totals))
        res = fail(&m, WEFT_ERR_LIMIT,
                   "%" PRIu64 " vertices and %" PRIu64 " triangles do not fit in memory",
                   totals.vertices, totals.indices / 3);
    if (res == WEFT_OK)
        res = take_nodes(&m, scene->mRootNode, &none);
    free(m.material);
    return res;
}

void weft_mesh_soup_clear(struct weft_mesh_soup *soup)
{
    free(soup->vertices);
    free(soup->objects);
    free(soup->indices);
    free(soup->parts);
    free(soup->materials);
    *soup = (struct weft_mesh_soup){0};
}
