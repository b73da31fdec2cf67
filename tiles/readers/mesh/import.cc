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
#include <assimp/postprocess.h>
#include <assimp/scene.h>

namespace
{

// A mapped file, or the file itself, which stays mapped.
class Stream : public Assimp::IOStream
{
  public:
    Stream(const struct weft_mesh_bytes &bytes, bool own) : bytes_(bytes), own_(own)
    {
    }
    ~Stream() override
    {
        if (own_)
            weft_mesh_bytes_release(&bytes_);
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
    bool own_;
    size_t at_ = 0;
};

class Files : public Assimp::IOSystem
{
  public:
    Files(struct weft_mesh_files *files, const std::string &main) : files_(files), main_(main)
    {
    }
    bool Exists(const char *name) const override
    {
        IOStream *stream = open(name);
        delete stream;
        return stream != nullptr;
    }
    char getOsSeparator() const override
    {
        return '/';
    }
    Assimp::IOStream *Open(const char *name, const char *mode) override
    {
        return strpbrk(mode, "wa+") ? nullptr : open(name);
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
    using IOStream = Assimp::IOStream;
    IOStream *open(const char *name) const
    {
        struct weft_mesh_bytes bytes;
        if (main_ == name)
            return new Stream(files_->main, false);
        // What is looked for under the file's own name with another ending was not named by it.
        if (!strncmp(name, WEFT_MESH_MAIN, strlen(WEFT_MESH_MAIN)))
            return nullptr;
        if (!weft_mesh_files_open(files_, name, &bytes))
            return nullptr;
        return new Stream(bytes, true);
    }
    struct weft_mesh_files *files_;
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

const aiScene *import(struct weft_mesh_files *files, enum weft_mesh_kind kind, std::string *error)
{
    const std::string name = std::string(WEFT_MESH_MAIN) + weft_mesh_endings[kind];
    // Never deleted: taking damaged trees apart may crash.
    auto importer = new Assimp::Importer;
    if (!keep_one(importer, kind)) {
        *error = "the assimp library lacks a decoder for it";
        return nullptr;
    }
    importer->SetIOHandler(new Files(files, name));
    const aiScene *scene = importer->ReadFile(name, aiProcess_Triangulate);
    if (!scene)
        *error = importer->GetErrorString();
    return scene;
}

} // namespace

enum weft_result weft_mesh_import(struct weft_mesh_files *files, enum weft_mesh_kind kind,
                                  const struct aiScene **out, char *message, size_t message_size)
{
    std::string error;
    *out = nullptr;
    try {
        *out = import(files, kind, &error);
    } catch (const std::exception &e) {
        error = e.what();
    } catch (...) {
        error = "unknown exception";
    }
    if (*out)
        return WEFT_OK;
    // assimp catches exceptions, and keeps their texts.
    const bool memory = error.find(std::bad_alloc().what()) != std::string::npos;
    snprintf(message, message_size, "%s",
             memory ? "its triangles do not fit in memory" : error.c_str());
    return memory ? WEFT_ERR_LIMIT : WEFT_ERR_FORMAT;
}
