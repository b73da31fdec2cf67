// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/mesh/import.h"

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <new>
#include <string>

#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/importerdesc.h>
#include <assimp/scene.h>

namespace
{

// A text that outlives it.
class Stream : public Assimp::IOStream
{
  public:
    explicit Stream(const struct weft_mesh_text &text) : bytes_{text.data, text.size}
    {
    }
    size_t Read(void *out, size_t size, size_t count) override
    {
        if (!size)
            return 0;
        count = std::min(count, (bytes_.size - at_) / size);
        if (count)
            memcpy(out, bytes_.data + at_, size * count);
        at_ += size * count;
        return count;
    }
    size_t Write(const void *, size_t, size_t) override
    {
        return 0;
    }
    // Offsets from the end are given as they are, or with their sign turned: none is asked for.
    aiReturn Seek(size_t offset, aiOrigin origin) override
    {
        const size_t from = origin == aiOrigin_SET ? 0 : at_;
        if (origin == aiOrigin_END || offset > bytes_.size - from)
            return aiReturn_FAILURE;
        at_ = from + offset;
        return aiReturn_SUCCESS;
    }
    size_t Tell() const override
    {
        return at_;
    }
    size_t FileSize() const override
    {
        return bytes_.size;
    }
    void Flush() override
    {
    }

  private:
    struct weft_mesh_bytes bytes_;
    size_t at_ = 0;
};

// The clean file's two texts are all there is: assimp opens nothing by itself.
class Files : public Assimp::IOSystem
{
  public:
    Files(const struct weft_mesh_clean *clean, const std::string &main) : clean_(clean), main_(main)
    {
    }
    bool Exists(const char *name) const override
    {
        return find(name) != nullptr;
    }
    char getOsSeparator() const override
    {
        return '/';
    }
    Assimp::IOStream *Open(const char *name, const char *mode) override
    {
        const struct weft_mesh_text *text = find(name);
        return text && !strpbrk(mode, "wa+") ? new Stream(*text) : nullptr;
    }
    void Close(Assimp::IOStream *stream) override
    {
        delete stream;
    }
    bool CreateDirectory(const std::string &) override
    {
        return false;
    }
    bool ChangeDirectory(const std::string &) override
    {
        return false;
    }
    bool DeleteFile(const std::string &) override
    {
        return false;
    }

  private:
    const struct weft_mesh_text *find(const char *name) const
    {
        return main_ == name                    ? &clean_->main
               : !strcmp(name, WEFT_MESH_OTHER) ? &clean_->other
                                                : nullptr;
    }
    const struct weft_mesh_clean *clean_;
    std::string main_;
};

// All decoders but one. It must not matter which ones a build of assimp has.
bool keep_one(Assimp::Importer *importer, enum weft_mesh_kind kind)
{
    static const char *const names[] = {"Wavefront Object Importer",
                                        "Stanford Polygon Library (PLY) Importer", "glTF2 Importer",
                                        "glTF2 Importer"};
    bool found = false;
    for (size_t i = importer->GetImporterCount(); i-- > 0;)
        if (!strcmp(importer->GetImporterInfo(i)->mName, names[kind]))
            found = true;
        else
            importer->UnregisterLoader(importer->GetImporter(i));
    return found && importer->GetImporterCount() == 1;
}

uint64_t count_faces(const aiScene *scene)
{
    uint64_t faces = 0;
    for (unsigned i = 0; i < scene->mNumMeshes; i++)
        faces += scene->mMeshes[i]->mNumFaces;
    return faces;
}

const aiScene *import(const struct weft_mesh_clean *clean, std::string *error)
{
    const enum weft_mesh_kind kind = clean->kind == WEFT_MESH_GLB ? WEFT_MESH_GLTF : clean->kind;
    const std::string name = std::string(WEFT_MESH_MAIN) + weft_mesh_endings[kind];
    // Never deleted: taking trees apart takes time.
    auto importer = new Assimp::Importer;
    if (!keep_one(importer, kind)) {
        *error = "the assimp library lacks a decoder for it";
        return nullptr;
    }
    importer->SetIOHandler(new Files(clean, name));
    const aiScene *scene = importer->ReadFile(name, 0);
    if (scene && clean->faces && count_faces(scene) != clean->faces) {
        *error = "the assimp library found " + std::to_string(count_faces(scene)) + " of " +
                 std::to_string(clean->faces) + " polygons";
        return nullptr;
    }
    if (!scene)
        *error = importer->GetErrorString();
    return scene;
}

} // namespace

enum weft_result weft_mesh_import(struct weft_mesh_clean *clean, const struct aiScene **out)
{
    std::string error;
    *out = nullptr;
    try {
        *out = import(clean, &error);
    } catch (const std::exception &e) {
        error = e.what();
    } catch (...) {
        error = "unknown exception";
    }
    if (*out)
        return WEFT_OK;
    // assimp catches exceptions, and keeps their texts.
    const bool memory = error.find(std::bad_alloc().what()) != std::string::npos;
    return weft_mesh_clean_fail(clean, memory ? WEFT_ERR_LIMIT : WEFT_ERR_FORMAT, "%s",
                                memory ? "its triangles do not fit in memory" : error.c_str());
}
