// SPDX-License-Identifier: BSD-3-Clause
// weft-read-dwa: the pixels of DWA-compressed EXR images, which OpenEXR's C++ library alone reads,
// for libweft, see wire.h. The header is weft-read-exr's; here it is checked only as far as memory
// and time depend on it.
#include <cerrno>
#include <cinttypes>
#include <cstdlib>
#include <cstring>
#include <new>
#include <stdexcept>

#include <sys/stat.h>
#include <unistd.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfInputPart.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfThreading.h>

#include "filter/check.h"
#include "tiles/image/image_wire.h"
#include "tiles/process/server.h"

namespace
{

// As weft-read-exr has them.
constexpr int64_t side_limit = INT64_C(1) << 29;
constexpr uint64_t ratio_limit = 10000, ratio_floor_bytes = UINT64_C(1) << 30;
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

struct Window {
    int64_t x, y, width, height;
    uint64_t channels, bytes;
};

bool measure(const Imf::Header &header, Window *out)
{
    const auto &box = header.dataWindow();
    *out = {box.min.x,
            box.min.y,
            int64_t(box.max.x) - box.min.x + 1,
            int64_t(box.max.y) - box.min.y + 1,
            0,
            0};
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c) {
        if (c.channel().xSampling != 1 || c.channel().ySampling != 1)
            return false;
        out->channels++;
    }
    return out->width > 0 && out->height > 0 && out->width < side_limit &&
           out->height < side_limit && out->channels > 0 && out->channels <= INT16_MAX;
}

weft_result check_amount(weft_server *server, Window *w, uint64_t file_bytes)
{
    size_t pixels, planes, bytes;
    if (!weft_size_mul(size_t(w->width), size_t(w->height), &pixels) ||
        !weft_size_mul(pixels, w->channels, &planes) || !weft_size_mul(planes, 4, &bytes))
        bytes = SIZE_MAX;
    w->bytes = bytes;
    if (bytes > server->limits.output_bytes)
        return weft_server_fail(server, WEFT_ERR_LIMIT,
                                "its pixels are %zu bytes, the output limit is %" PRIu64, bytes,
                                server->limits.output_bytes);
    if (bytes > ratio_floor_bytes && bytes / ratio_limit > file_bytes)
        return weft_server_fail(server, WEFT_ERR_LIMIT,
                                "%zu bytes are declared in a file of %" PRIu64
                                " bytes, the limit is %" PRIu64 " times as many",
                                bytes, file_bytes, ratio_limit);
    return WEFT_OK;
}

// Slices are addressed from pixel (0, 0) of an endless plane.
Imf::FrameBuffer make_frame(const Imf::Header &header, const Window &w, char *planes)
{
    Imf::FrameBuffer frame;
    const uint64_t plane_bytes = uint64_t(w.width) * uint64_t(w.height) * 4;
    const auto base =
        reinterpret_cast<uintptr_t>(planes) - static_cast<uintptr_t>(4 * (w.y * w.width + w.x));
    size_t i = 0;
    for (auto c = header.channels().begin(); c != header.channels().end(); ++c, ++i) {
        const auto type = c.channel().type == Imf::UINT ? Imf::UINT : Imf::FLOAT;
        frame.insert(c.name(), Imf::Slice(type, reinterpret_cast<char *>(base + i * plane_bytes), 4,
                                          size_t(w.width) * 4));
    }
    return frame;
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

weft_result read_pixels(weft_server *server)
{
    struct stat st;
    if (server->request->op != WEFT_WIRE_IMAGE_PIXELS)
        return weft_server_fail(server, WEFT_ERR_READER, "weft-read-dwa: unknown request %" PRIu32,
                                server->request->op);
    if (fstat(server->input_fd, &st))
        return weft_server_fail(server, WEFT_ERR_OPEN, "%s", strerror(errno));
    FileStream stream(server->input_fd, server->path, uint64_t(st.st_size));
    Imf::MultiPartInputFile file(stream, start_threads(server), false);
    const auto part = server->request->part;
    if (part >= static_cast<uint32_t>(file.parts()))
        return weft_server_fail(server, WEFT_ERR_ARGUMENT, "there is no part %" PRIu32, part);
    const Imf::Header &header = file.header(int(part));
    Window window;
    if (!measure(header, &window) || (header.hasType() && Imf::isDeepData(header.type())))
        return weft_server_fail(server, WEFT_ERR_UNSUPPORTED, "its windows or channels are unfit");
    weft_result res = check_amount(server, &window, uint64_t(st.st_size));
    if (res != WEFT_OK)
        return res;
    const auto planes = static_cast<char *>(weft_server_map(server, window.bytes));
    if (!planes)
        return static_cast<weft_result>(server->answer.result);
    Imf::InputPart input(file, int(part));
    input.setFrameBuffer(make_frame(header, window, planes));
    input.readPixels(int(window.y), int(window.y + window.height - 1));
    return WEFT_OK;
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
    return weft_server_run(argc, argv, handle, nullptr);
}
