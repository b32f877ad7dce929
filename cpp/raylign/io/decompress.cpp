// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/io/decompress.h"

#include <bzlib.h>
#include <zlib.h>

#include <algorithm>
#include <limits>
#include <new>
#include <utility>
#include <vector>

#include "raylign/base/error.h"

namespace raylign {
namespace {

constexpr std::size_t kInputChunk = std::size_t{1} << 16;

// zlib and libbz2 have the same shape of stream (next_in, avail_in, next_out, avail_out); a Codec
// gives the calls that differ. State of one call to run():
enum class Step { MORE, MEMBER_END, CORRUPT };

struct GzipCodec {
  static constexpr const char* kName = "gzip stream";
  using Stream = z_stream;
  using Byte = Bytef;
  // 16 + MAX_WBITS: gzip wrapper only, checksum and length verified by zlib.
  static bool start(Stream& stream) { return inflateInit2(&stream, 16 + MAX_WBITS) == Z_OK; }
  static bool restart(Stream& stream) { return inflateReset(&stream) == Z_OK; }
  static void stop(Stream& stream) { inflateEnd(&stream); }
  static Step run(Stream& stream) {
    const int status = inflate(&stream, Z_NO_FLUSH);
    if (status == Z_STREAM_END) return Step::MEMBER_END;
    return status == Z_OK || status == Z_BUF_ERROR ? Step::MORE : Step::CORRUPT;
  }
};

struct Bzip2Codec {
  static constexpr const char* kName = "bzip2 stream";
  using Stream = bz_stream;
  using Byte = char;
  static bool start(Stream& stream) { return BZ2_bzDecompressInit(&stream, 0, 0) == BZ_OK; }
  // libbz2 has no reset: the input position is carried over by hand.
  static bool restart(Stream& stream) {
    const Stream before = stream;
    stop(stream);
    stream = Stream{};
    stream.next_in = before.next_in;
    stream.avail_in = before.avail_in;
    stream.next_out = before.next_out;
    stream.avail_out = before.avail_out;
    return start(stream);
  }
  static void stop(Stream& stream) { BZ2_bzDecompressEnd(&stream); }
  static Step run(Stream& stream) {
    const int status = BZ2_bzDecompress(&stream);
    if (status == BZ_STREAM_END) return Step::MEMBER_END;
    return status == BZ_OK ? Step::MORE : Step::CORRUPT;
  }
};

std::int64_t expansion_limit(std::int64_t compressed_size) {
  constexpr std::int64_t kMax = std::numeric_limits<std::int64_t>::max();
  if (compressed_size > (kMax - kExpansionSlack) / kMaxExpansion) return kMax;
  return compressed_size * kMaxExpansion + kExpansionSlack;
}

template <typename Codec>
class Decompressor final : public ByteSource {
 public:
  Decompressor(std::unique_ptr<ByteSource> compressed, std::string name)
      : compressed_(std::move(compressed)),
        name_(std::move(name)),
        limit_(expansion_limit(compressed_->max_size())),
        input_(kInputChunk) {
    if (!Codec::start(stream_)) throw std::bad_alloc();
  }
  ~Decompressor() override { Codec::stop(stream_); }
  Decompressor(const Decompressor&) = delete;
  Decompressor& operator=(const Decompressor&) = delete;

  std::size_t read(char* destination, std::size_t capacity) override {
    stream_.next_out = reinterpret_cast<typename Codec::Byte*>(destination);
    stream_.avail_out = static_cast<unsigned>(std::min(capacity, std::size_t{1} << 30));
    const unsigned requested = stream_.avail_out;
    while (!at_end_ && stream_.avail_out == requested) advance();
    const std::size_t count = requested - stream_.avail_out;
    produced_ += static_cast<std::int64_t>(count);
    if (produced_ > limit_) {
      fail("expands to more than " + std::to_string(kMaxExpansion) +
           " times its size: refused as a decompression bomb");
    }
    return count;
  }

  std::int64_t max_size() const override { return limit_; }
  bool size_is_exact() const override { return false; }

 private:
  [[noreturn]] void fail(const std::string& reason) const {
    throw FormatError(name_, 0, Codec::kName, reason);
  }

  // Makes stream_.avail_in > 0; false at the end of the compressed bytes.
  bool refill() {
    if (stream_.avail_in > 0) return true;
    const std::size_t count = compressed_->read(input_.data(), input_.size());
    stream_.next_in = reinterpret_cast<typename Codec::Byte*>(input_.data());
    stream_.avail_in = static_cast<unsigned>(count);
    return count > 0;
  }

  void advance() {
    if (between_members_) {
      start_next_member();
      return;
    }
    const bool has_input = refill();
    const unsigned available = stream_.avail_in;
    const unsigned room = stream_.avail_out;
    const Step step = Codec::run(stream_);
    if (step == Step::CORRUPT) fail("corrupt data");
    between_members_ = step == Step::MEMBER_END;
    const bool stuck = stream_.avail_in == available && stream_.avail_out == room;
    if (!between_members_ && !has_input && stuck) fail("truncated: the file ends inside it");
  }

  // After a member: another one, zero padding (as on tapes, ignored like gzip does), or the end.
  void start_next_member() {
    while (refill() && *stream_.next_in == 0) {
      ++stream_.next_in;
      --stream_.avail_in;
    }
    if (stream_.avail_in == 0) {
      at_end_ = true;
      return;
    }
    if (!Codec::restart(stream_)) throw std::bad_alloc();
    between_members_ = false;
  }

  std::unique_ptr<ByteSource> compressed_;
  std::string name_;
  std::int64_t limit_;
  std::vector<char> input_;
  typename Codec::Stream stream_{};
  std::int64_t produced_ = 0;
  bool between_members_ = false;
  bool at_end_ = false;
};

}  // namespace

Compression detect_compression(std::string_view head) {
  const auto starts_with = [head](std::string_view magic) {
    return head.substr(0, magic.size()) == magic;
  };
  if (starts_with("\x1f\x8b")) return Compression::GZIP;
  if (starts_with("BZh")) return Compression::BZIP2;
  return Compression::NONE;
}

std::unique_ptr<ByteSource> make_decompressor(Compression compression,
                                              std::unique_ptr<ByteSource> compressed,
                                              const std::string& name) {
  if (compression == Compression::BZIP2) {
    return std::make_unique<Decompressor<Bzip2Codec>>(std::move(compressed), name);
  }
  return std::make_unique<Decompressor<GzipCodec>>(std::move(compressed), name);
}

}  // namespace raylign
