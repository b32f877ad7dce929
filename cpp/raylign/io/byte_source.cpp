// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/io/byte_source.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <system_error>
#include <utility>

#include "raylign/base/error.h"
#include "raylign/io/decompress.h"

namespace raylign {
namespace {

constexpr std::size_t kMagicSize = 4;

[[noreturn]] void throw_errno(const std::string& path, const char* what) {
  throw FormatError(path, 0, "", what + std::generic_category().message(errno));
}

class FileSource final : public ByteSource {
 public:
  explicit FileSource(std::string path)
      : path_(std::move(path)), descriptor_(::open(path_.c_str(), O_RDONLY | O_CLOEXEC)) {
    if (descriptor_ < 0) throw_errno(path_, "cannot be opened: ");
  }
  ~FileSource() override { ::close(descriptor_); }
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;

  // Called once by open_byte_source: a constructor that throws would leave the descriptor open.
  void inspect() {
    struct stat info{};
    if (::fstat(descriptor_, &info) != 0) throw_errno(path_, "cannot be read: ");
    if (S_ISDIR(info.st_mode)) throw FormatError(path_, 0, "", "is a directory");
    is_regular_ = S_ISREG(info.st_mode);
    size_ = is_regular_ ? info.st_size : std::numeric_limits<std::int64_t>::max();
  }

  std::size_t read(char* destination, std::size_t capacity) override {
    ssize_t count = 0;
    do {
      count = ::read(descriptor_, destination, capacity);
    } while (count < 0 && errno == EINTR);
    if (count < 0) throw_errno(path_, "cannot be read: ");
    return static_cast<std::size_t>(count);
  }

  std::int64_t max_size() const override { return size_; }
  bool size_is_exact() const override { return is_regular_; }

 private:
  std::string path_;
  int descriptor_;
  std::int64_t size_ = 0;
  bool is_regular_ = false;
};

class MemorySource final : public ByteSource {
 public:
  explicit MemorySource(std::string_view bytes)
      : rest_(bytes), size_(static_cast<std::int64_t>(bytes.size())) {}

  std::size_t read(char* destination, std::size_t capacity) override {
    const std::size_t count = std::min(capacity, rest_.size());
    std::memcpy(destination, rest_.data(), count);
    rest_.remove_prefix(count);
    return count;
  }

  std::int64_t max_size() const override { return size_; }
  bool size_is_exact() const override { return true; }

 private:
  std::string_view rest_;
  std::int64_t size_;
};

// Gives back the bytes that were read to look at the magic, then the rest.
class RewoundSource final : public ByteSource {
 public:
  RewoundSource(std::string head, std::unique_ptr<ByteSource> rest)
      : head_(std::move(head)), rest_(std::move(rest)) {}

  std::size_t read(char* destination, std::size_t capacity) override {
    if (used_ == head_.size()) return rest_->read(destination, capacity);
    const std::size_t count = std::min(capacity, head_.size() - used_);
    std::memcpy(destination, head_.data() + used_, count);
    used_ += count;
    return count;
  }

  std::int64_t max_size() const override { return rest_->max_size(); }
  bool size_is_exact() const override { return rest_->size_is_exact(); }

 private:
  std::string head_;
  std::size_t used_ = 0;
  std::unique_ptr<ByteSource> rest_;
};

std::unique_ptr<ByteSource> decompress_if_needed(std::unique_ptr<ByteSource> source,
                                                 const std::string& name) {
  std::string head(kMagicSize, '\0');
  std::size_t filled = 0;
  while (filled < kMagicSize) {
    const std::size_t count = source->read(head.data() + filled, kMagicSize - filled);
    if (count == 0) break;
    filled += count;
  }
  head.resize(filled);
  if (head.empty()) throw FormatError(name, 0, "", "is empty");
  const Compression compression = detect_compression(head);
  auto rewound = std::make_unique<RewoundSource>(std::move(head), std::move(source));
  if (compression == Compression::NONE) return rewound;
  return make_decompressor(compression, std::move(rewound), name);
}

}  // namespace

std::unique_ptr<ByteSource> open_byte_source(const std::string& path) {
  auto file = std::make_unique<FileSource>(path);
  file->inspect();
  return decompress_if_needed(std::move(file), path);
}

std::unique_ptr<ByteSource> make_byte_source(std::string_view bytes, const std::string& name) {
  return decompress_if_needed(std::make_unique<MemorySource>(bytes), name);
}

}  // namespace raylign
