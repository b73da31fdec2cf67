// SPDX-License-Identifier: BSD-3-Clause
// weft-read-dwa: the pixels of DWA-compressed EXR images, which OpenEXR's C++ library alone reads,
// for libweft, see wire.h. Headers are read and checked as weft-read-exr does it.
#include <cerrno>
#include <cinttypes>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>

#include <unistd.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfThreading.h>

#include "tiles/readers/exr_file.h"

namespace
{

constexpr int most_threads = 64;

class FileStream : public Imf::IStream
{
  public:
    FileStream(int fd, const char *path, uint64_t size) : IStream(path), fd_(fd), size_(size)
    {
    }
    bool read(char *out, int count) override
    {
        if (count < 0 || at_ > size_ || static_cast<uint64_t>(count) > size_ - at_)
            throw std::runtime_error("it is cut short");
        while (count > 0) {
            ssize_t n = pread(fd_, out, static_cast<size_t>(count), static_cast<off_t>(at_));
            if (n < 0 && errno == EINTR)
                continue;
            if (n <= 0)
                throw std::runtime_error(n < 0 ? strerror(errno) : "it is cut short");
            out += n;
            count -= static_cast<int>(n);
            at_ += static_cast<uint64_t>(n);
        }
        return at_ < size_;
    }
    uint64_t tellg() override
    {
        return at_;
    }
    void seekg(uint64_t position) override
    {
        at_ = position;
    }

  private:
    int fd_;
    uint64_t size_, at_ = 0;
};

// Where pixels go, and in which types: as the channels have them, or in four bytes a value.
struct Planes {
    char *data;
    bool own_types;
};

// Slices are addressed from pixel (0, 0) of an endless plane.
Imf::FrameBuffer make_frame(const Imf::Header &header, const weft_exr_file &file,
                            const Planes &planes)
{
    Imf::FrameBuffer frame;
    auto at = reinterpret_cast<uintptr_t>(planes.data);
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        const auto type = c.channel().type;
        const bool half = type == Imf::HALF && planes.own_types;
        const int64_t value = half ? 2 : 4;
        const auto base =
            at - static_cast<uintptr_t>(
                     value * ((file.data.min.y + file.first_row) * file.width + file.data.min.x));
        frame.insert(c.name(), Imf::Slice(half                ? Imf::HALF
                                          : type == Imf::UINT ? Imf::UINT
                                                              : Imf::FLOAT,
                                          reinterpret_cast<char *>(base), size_t(value),
                                          size_t(file.width * value)));
        size_t bytes = size_t(file.width) * size_t(file.rows) * size_t(value);
        if (planes.own_types)
            weft_wire_align(bytes, &bytes);
        at += bytes;
    }
    return frame;
}

// Both libraries must say the same of the header, which was checked through the other one.
bool agrees(const Imf::Header &header, const weft_exr_file &file)
{
    const auto &box = header.dataWindow();
    int i = 0;
    if (header.hasType() && Imf::isDeepData(header.type()))
        return false;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c, ++i) {
        if (i == file.channels->num_channels)
            return false;
        const auto &entry = file.channels->entries[i];
        if (std::strcmp(c.name(), entry.name.str) || int(c.channel().type) != int(entry.pixel_type))
            return false;
    }
    return i == file.channels->num_channels && box.min.x == file.data.min.x &&
           box.min.y == file.data.min.y && box.max.x == file.data.max.x &&
           box.max.y == file.data.max.y;
}

// The library's own pool, or none where the limits leave no room for it.
int start_threads(const weft_server *server)
{
    const int wanted =
        server->request->threads < most_threads ? int(server->request->threads) : most_threads;
    try {
        Imf::setGlobalThreadCount(wanted > 1 ? wanted : 0);
    } catch (const std::exception &) {
        Imf::setGlobalThreadCount(0);
    }
    return Imf::globalThreadCount();
}

weft_result read_planes(const weft_exr_file &exr, const Planes &planes)
{
    weft_server *server = exr.server;
    FileStream stream(server->input_fd, server->path, exr.file_bytes);
    Imf::MultiPartInputFile file(stream, start_threads(server), false);
    if (exr.part >= file.parts() || !agrees(file.header(exr.part), exr))
        return weft_server_fail(server, WEFT_ERR_FORMAT,
                                "its channels are not in the order of their names, or its header "
                                "is ambiguous");
    Imf::InputPart input(file, exr.part);
    input.setFrameBuffer(make_frame(file.header(exr.part), exr, planes));
    const int first = exr.data.min.y + int(exr.first_row);
    input.readPixels(first, first + int(exr.rows) - 1);
    return WEFT_OK;
}

weft_result answer(weft_exr_file &exr)
{
    weft_server *server = exr.server;
    const bool frame = server->request->op == WEFT_WIRE_IMAGE_FRAME;
    Planes planes = {nullptr, frame};
    size_t bytes = 0;
    if (frame && !weft_exr_is_dwa(&exr)) {
        server->answer.verdict = WEFT_WIRE_OTHER_PROGRAM;
        return WEFT_OK;
    }
    weft_result res = weft_exr_check_kind(&exr);
    if (res == WEFT_OK && !frame)
        res = weft_exr_choose_rows(&exr, 1);
    if (res == WEFT_OK)
        res = weft_exr_measure(&exr, frame, &bytes);
    if (res == WEFT_OK && frame)
        res = weft_exr_begin_frame(&exr, bytes, &planes.data);
    else if (res == WEFT_OK)
        planes.data = static_cast<char *>(weft_server_map(server, bytes));
    if (planes.data)
        return read_planes(exr, planes);
    return res == WEFT_OK ? static_cast<weft_result>(server->answer.result) : res;
}

weft_result read_pixels(weft_server *server)
{
    auto &exr = *static_cast<weft_exr_file *>(server->priv);
    const auto op = server->request->op;
    if (op != WEFT_WIRE_IMAGE_PIXELS && op != WEFT_WIRE_IMAGE_FRAME)
        return weft_server_fail(server, WEFT_ERR_READER, "weft-read-dwa: unknown request %" PRIu32,
                                op);
    exr.server = server;
    exr.complaint = weft_exr_complaint();
    weft_exr_complain(&exr.complaint);
    weft_exr_close(&exr); // the one before
    weft_result res = weft_exr_open(&exr);
    if (res == WEFT_OK)
        res = weft_exr_take_part(&exr, server->request->part);
    return res == WEFT_OK ? answer(exr) : res;
}

weft_result handle(weft_server *server)
{
    try {
        return read_pixels(server);
    } catch (const std::bad_alloc &) {
        return weft_server_fail(server, WEFT_ERR_LIMIT,
                                "more memory is needed than the limit of %" PRIu64 " bytes",
                                server->limits.memory_bytes);
    } catch (const std::exception &error) {
        return weft_server_fail(server, WEFT_ERR_FORMAT, "OpenEXR says: %.400s", error.what());
    } catch (...) {
        return weft_server_fail(server, WEFT_ERR_FORMAT, "OpenEXR failed without a reason");
    }
}

} // namespace

int main(int argc, char **argv)
{
    Imf::setGlobalThreadCount(0);
    weft_exr_file exr = {};
    return weft_server_run(argc, argv, handle, &exr);
}
