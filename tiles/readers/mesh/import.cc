// SPDX-License-Identifier: BSD-3-Clause
#include "tiles/readers/mesh/import.h"

#include <algorithm>
#include <cctype>
#include <cstring>
#include <new>
#include <string>

#include <assimp/DefaultLogger.hpp>
#include <assimp/IOStream.hpp>
#include <assimp/IOSystem.hpp>
#include <assimp/Importer.hpp>
#include <assimp/LogStream.hpp>
#include <assimp/importerdesc.h>
#include <assimp/scene.h>

namespace
{

// Bytes that outlive it.
class Stream : public Assimp::IOStream
{
  public:
    explicit Stream(const struct weft_mesh_bytes &bytes) : bytes_(bytes)
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

// RFC 3986, section 2.1: glTF names files in URIs, of which assimp takes escapes as they are.
std::string unescaped(const std::string &uri)
{
    std::string name;
    for (size_t i = 0; i < uri.size(); i++) {
        const bool escape = uri[i] == '%' && i + 2 < uri.size() &&
                            isxdigit(static_cast<unsigned char>(uri[i + 1])) &&
                            isxdigit(static_cast<unsigned char>(uri[i + 2])) &&
                            uri.compare(i, 3, "%00");
        name += escape ? static_cast<char>(std::stoi(uri.substr(i + 1, 2), nullptr, 16)) : uri[i];
        i += escape ? 2 : 0;
    }
    return name;
}

// The file itself has a name that no file has: assimp looks for libraries of the same name.
class Files : public Assimp::IOSystem
{
  public:
    Files(struct weft_mesh_source *source, const std::string &main) : source_(source), main_(main)
    {
    }
    bool Exists(const char *name) const override
    {
        return main_ == name;
    }
    char getOsSeparator() const override
    {
        return '/';
    }
    Assimp::IOStream *Open(const char *name, const char *mode) override
    {
        struct weft_mesh_bytes bytes = source_->files->main;
        if (strpbrk(mode, "wa+"))
            return nullptr;
        if (main_ != name) {
            const std::string plain = source_->kind >= WEFT_MESH_GLTF ? unescaped(name) : name;
            return weft_mesh_files_open(source_->files, plain.c_str(), &bytes) ? new Stream(bytes)
                                                                               : nullptr;
        }
        if (source_->text)
            bytes = {source_->text, source_->size};
        return new Stream(bytes);
    }
    void Close(Assimp::IOStream *stream) override
    {
        delete stream;
    }

  private:
    struct weft_mesh_source *source_;
    std::string main_;
};

// Keeps the first of assimp's warnings that says that something of a mesh is left out.
class Complaints : public Assimp::LogStream
{
  public:
    void write(const char *message) override
    {
        static const char *const bad[] = {"dropped",   "out-of-range",  "does not match",
                                          "ignored",   "Ignoring",      "Skipping",
                                          "not found", "Not supported", "Invalid",
                                          "invalid",   "corrupt",       "non-contiguous"};
        const char *text = strchr(message, ':'); // "Warn,  T0: "
        for (const char *word : bad)
            if (first.empty() && strstr(message, word))
                first = text ? text + 2 : message;
        while (!first.empty() && first.back() == '\n')
            first.pop_back();
    }
    std::string first;
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

// Polygons of three corners and more.
uint64_t count_faces(const aiScene *scene)
{
    uint64_t faces = 0;
    for (unsigned i = 0; i < scene->mNumMeshes; i++)
        for (unsigned f = 0; f < scene->mMeshes[i]->mNumFaces; f++)
            faces += scene->mMeshes[i]->mFaces[f].mNumIndices >= 3;
    return faces;
}

const aiScene *import(struct weft_mesh_source *source, std::string *error)
{
    const std::string name = std::string("\1main") + weft_mesh_endings[source->kind];
    // Never deleted: taking trees apart takes time.
    auto importer = new Assimp::Importer;
    auto complaints = new Complaints;
    if (!keep_one(importer, source->kind)) {
        *error = "the assimp library lacks a decoder for it";
        return nullptr;
    }
    Assimp::DefaultLogger::create("", Assimp::Logger::NORMAL, 0);
    Assimp::DefaultLogger::get()->attachStream(complaints,
                                               Assimp::Logger::Warn | Assimp::Logger::Err);
    importer->SetIOHandler(new Files(source, name));
    const aiScene *scene = importer->ReadFile(name, 0);
    const struct weft_mesh_files *files = source->files;
    if (*files->refused)
        *error = files->refused;
    else if (!scene && *files->missing)
        *error = files->missing;
    else if (!complaints->first.empty())
        *error = "the assimp library says: " + complaints->first;
    else if (!scene)
        *error = importer->GetErrorString();
    else if (source->faces && count_faces(scene) != source->faces)
        *error = "the assimp library found " + std::to_string(count_faces(scene)) + " of " +
                 std::to_string(source->faces) + " polygons";
    else
        return scene;
    return nullptr;
}

} // namespace

enum weft_result weft_mesh_import(struct weft_mesh_source *source, const struct aiScene **out)
{
    std::string error;
    *out = nullptr;
    try {
        *out = import(source, &error);
    } catch (const std::exception &e) {
        error = e.what();
    } catch (...) {
        error = "unknown exception";
    }
    if (*out)
        return WEFT_OK;
    // assimp catches exceptions, and keeps their texts.
    const bool memory = error.find(std::bad_alloc().what()) != std::string::npos;
    return weft_mesh_fail(source, memory ? WEFT_ERR_LIMIT : WEFT_ERR_FORMAT, "%s",
                          memory ? "its triangles do not fit in memory" : error.c_str());
}
