// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/io/byte_sink.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "raylign/base/error.h"
#include "raylign/io/compress.h"

namespace raylign {
namespace {

namespace fs = std::filesystem;

[[noreturn]] void fail(const std::string& path, const std::string& why) {
  throw FormatError(path, 0, "", "cannot be written: " + why);
}

[[noreturn]] void fail_errno(const std::string& path) {
  fail(path, std::generic_category().message(errno));
}

class FileSink final : public ByteSink {
 public:
  explicit FileSink(std::string path) : path_(std::move(path)) {
    std::error_code error;
    const fs::file_status status = fs::status(path_, error);
    if (fs::is_directory(status)) fail(path_, "is a directory");
    if (fs::exists(status) && !fs::is_regular_file(status)) {
      descriptor_ = ::open(path_.c_str(), O_WRONLY | O_CLOEXEC);
    } else {
      open_temporary(status);
    }
    if (descriptor_ < 0) fail_errno(path_);
  }

  ~FileSink() override {
    if (descriptor_ >= 0) ::close(descriptor_);
    if (!temporary_.empty()) ::unlink(temporary_.c_str());
  }
  FileSink(const FileSink&) = delete;
  FileSink& operator=(const FileSink&) = delete;

  void write(std::string_view bytes) override {
    while (!bytes.empty()) {
      const ssize_t count = ::write(descriptor_, bytes.data(), bytes.size());
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) fail_errno(path_);
      bytes.remove_prefix(static_cast<std::size_t>(count));
    }
  }

  void finish() override {
    if (::close(std::exchange(descriptor_, -1)) != 0) fail_errno(path_);
    if (temporary_.empty()) return;
    if (std::rename(temporary_.c_str(), target_.c_str()) != 0) fail_errno(path_);
    temporary_.clear();
  }

  const std::string& name() const override { return path_; }

 private:
  // Beside the file that `path_` leads to, so that the rename stays inside one file system.
  void open_temporary(const fs::file_status& status) {
    std::error_code error;
    target_ = fs::exists(status) ? fs::canonical(path_, error).string() : path_;
    if (error) fail(path_, error.message());
    if (fs::exists(status) && ::access(target_.c_str(), W_OK) != 0) fail_errno(path_);
    for (int attempt = 0; attempt < 100; ++attempt) {
      std::string candidate =
          target_ + ".tmp-" + std::to_string(::getpid()) + "-" + std::to_string(attempt);
      descriptor_ = ::open(candidate.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
      if (descriptor_ < 0 && errno == EEXIST) continue;
      if (descriptor_ < 0) return;
      temporary_ = std::move(candidate);
      if (fs::exists(status)) ::fchmod(descriptor_, static_cast<mode_t>(status.permissions()));
      return;
    }
  }

  std::string path_;
  std::string target_;
  std::string temporary_;  // empty when writing directly, or after the rename
  int descriptor_ = -1;
};

class StringSink final : public ByteSink {
 public:
  explicit StringSink(std::string* text) : text_(text) {}
  void write(std::string_view bytes) override { text_->append(bytes); }
  void finish() override {}
  const std::string& name() const override { return name_; }

 private:
  std::string* text_;
  std::string name_ = "<memory>";
};

Compression compression_of_name(const std::string& path) {
  const std::string suffix = fs::path(path).extension().string();
  if (suffix == ".gz") return Compression::GZIP;
  return suffix == ".bz2" ? Compression::BZIP2 : Compression::NONE;
}

}  // namespace

std::unique_ptr<ByteSink> open_byte_sink(const std::string& path) {
  return make_compressor(compression_of_name(path), std::make_unique<FileSink>(path));
}

std::unique_ptr<ByteSink> make_string_sink(std::string* text) {
  return std::make_unique<StringSink>(text);
}

}  // namespace raylign
