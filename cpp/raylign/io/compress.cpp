// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/io/compress.h"

#include <bzlib.h>
#include <zlib.h>

#include <algorithm>
#include <new>
#include <utility>
#include <vector>

namespace raylign {
namespace {

constexpr std::size_t kOutputChunk = std::size_t{1} << 16;
constexpr std::size_t kMaxInputPiece = std::size_t{1} << 30;  // avail_in is 32 bits

// run() returns true when the stream has nothing more to give for the input and the mode it got.
struct GzipEncoder {
  using Stream = z_stream;
  using Byte = Bytef;
  static bool start(Stream& stream) {
    return deflateInit2(&stream, Z_DEFAULT_COMPRESSION, Z_DEFLATED, 16 + MAX_WBITS, 8,
                        Z_DEFAULT_STRATEGY) == Z_OK;
  }
  static void stop(Stream& stream) { deflateEnd(&stream); }
  static bool run(Stream& stream, bool last) {
    const int status = deflate(&stream, last ? Z_FINISH : Z_NO_FLUSH);
    return last ? status == Z_STREAM_END : stream.avail_in == 0;
  }
};

struct Bzip2Encoder {
  using Stream = bz_stream;
  using Byte = char;
  static bool start(Stream& stream) { return BZ2_bzCompressInit(&stream, 9, 0, 0) == BZ_OK; }
  static void stop(Stream& stream) { BZ2_bzCompressEnd(&stream); }
  static bool run(Stream& stream, bool last) {
    const int status = BZ2_bzCompress(&stream, last ? BZ_FINISH : BZ_RUN);
    return last ? status == BZ_STREAM_END : stream.avail_in == 0;
  }
};

template <typename Encoder>
class Compressor final : public ByteSink {
 public:
  explicit Compressor(std::unique_ptr<ByteSink> target)
      : target_(std::move(target)), output_(kOutputChunk) {
    if (!Encoder::start(stream_)) throw std::bad_alloc();
  }
  ~Compressor() override { Encoder::stop(stream_); }
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;

  void write(std::string_view bytes) override {
    while (!bytes.empty()) {
      const std::size_t count = std::min(bytes.size(), kMaxInputPiece);
      // Both libraries take a pointer to non-const input and only read it.
      stream_.next_in = reinterpret_cast<typename Encoder::Byte*>(const_cast<char*>(bytes.data()));
      stream_.avail_in = static_cast<unsigned>(count);
      drain(false);
      bytes.remove_prefix(count);
    }
  }

  void finish() override {
    drain(true);
    target_->finish();
  }

  const std::string& name() const override { return target_->name(); }

 private:
  void drain(bool last) {
    bool done = false;
    while (!done) {
      stream_.next_out = reinterpret_cast<typename Encoder::Byte*>(output_.data());
      stream_.avail_out = static_cast<unsigned>(output_.size());
      done = Encoder::run(stream_, last);
      target_->write({output_.data(), output_.size() - stream_.avail_out});
    }
  }

  std::unique_ptr<ByteSink> target_;
  std::vector<char> output_;
  typename Encoder::Stream stream_{};
};

}  // namespace

std::unique_ptr<ByteSink> make_compressor(Compression compression,
                                          std::unique_ptr<ByteSink> target) {
  switch (compression) {
    case Compression::GZIP:
      return std::make_unique<Compressor<GzipEncoder>>(std::move(target));
    case Compression::BZIP2:
      return std::make_unique<Compressor<Bzip2Encoder>>(std::move(target));
    case Compression::NONE:
      break;
  }
  return target;
}

}  // namespace raylign
