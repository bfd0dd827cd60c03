/* SPDX-FileCopyrightText: 2026 The ddof authors
 * SPDX-License-Identifier: MIT */

#include "exr_dwa.h"

#include <cstdint>
#include <cstdio>
#include <cstring>
#include <exception>

#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfInputFile.h>
#include <Iex.h>

namespace {

class Memory : public Imf::IStream {
  public:
    Memory(const void *data, size_t size)
        : Imf::IStream("memory"), data_(static_cast<const char *>(data)), size_(size) {}
    bool isMemoryMapped() const override { return false; }
    bool read(char to[], int count) override {
        if (count < 0 || static_cast<uint64_t>(count) > size_ - at_) throw Iex::InputExc("early end of the pixels");
        std::memcpy(to, data_ + at_, static_cast<size_t>(count));
        at_ += static_cast<uint64_t>(count);
        return at_ < size_;
    }
    uint64_t tellg() override { return at_; }
    void seekg(uint64_t position) override {
        if (position > size_) throw Iex::InputExc("an offset beyond the end");
        at_ = position;
    }

  private:
    const char *data_;
    uint64_t size_, at_ = 0;
};

/* The library addresses pixel (x, y) as base + x / sampling * stride: base lies outside of our data. */
Imf::Slice slice_of(const io_exr_slice &slice, int x, int y) {
    static const Imf::PixelType types[] = {Imf::UINT, Imf::HALF, Imf::FLOAT};
    intptr_t sample = slice.type == 1 ? 2 : 4, row = slice.width * sample;
    intptr_t base = reinterpret_cast<intptr_t>(slice.data) - x / slice.x_sampling * sample - y / slice.y_sampling * row;
    return Imf::Slice(types[slice.type], reinterpret_cast<char *>(base), static_cast<size_t>(sample),
                      static_cast<size_t>(row), slice.x_sampling, slice.y_sampling);
}

} // namespace

int io_exr_dwa_decode(const void *file, size_t size, int x, int y, int top, int bottom, const io_exr_slice *slices,
                      int count, char *reason, size_t reason_size) {
    try {
        Memory stream(file, size);
        Imf::InputFile input(stream, 0); /* without the library's own threads, which the process may want for itself */
        Imf::FrameBuffer frame;
        for (int i = 0; i < count; i++)
            frame.insert(slices[i].name, slice_of(slices[i], x, y));
        input.setFrameBuffer(frame);
        input.readPixels(top, bottom);
        return 0;
    } catch (const std::exception &e) {
        std::snprintf(reason, reason_size, "%s", e.what());
    } catch (...) {
        std::snprintf(reason, reason_size, "unknown reason");
    }
    return -1;
}
