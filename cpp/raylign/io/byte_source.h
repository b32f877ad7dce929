// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

namespace raylign {

/// A stream of bytes that is read once, front to back.
class ByteSource {
 public:
  virtual ~ByteSource() = default;

  /// Fills at most `capacity` > 0 bytes and returns their number; 0 only at the end. Throws
  /// FormatError when the bytes cannot be had.
  virtual std::size_t read(char* destination, std::size_t capacity) = 0;

  /// No more than this many bytes will come: what a reader may allocate is measured against it.
  virtual std::int64_t max_size() const = 0;

  /// True when max_size() is the exact size, false when it is only a bound.
  virtual bool size_is_exact() const = 0;
};

/// Opens a file, or the text inside it when its first bytes say gzip or bzip2 (whatever its name
/// says). A file is read in pieces rather than mapped: another process that shortens it while we
/// read then causes an error and not SIGBUS, and pipes work too; both ways are equally fast here.
/// Throws FormatError for a file that is missing, unreadable, a directory, or empty.
std::unique_ptr<ByteSource> open_byte_source(const std::string& path);

/// The same for bytes in memory, which must outlive the source; `name` stands in for the path in
/// messages.
std::unique_ptr<ByteSource> make_byte_source(std::string_view bytes, const std::string& name);

/// Compressed input may grow by this factor, plus the slack; text that grows more is not a scene
/// but a decompression bomb. (Numbers as text carry over 3 bits per byte, so real files grow three-
/// to fivefold.)
constexpr std::int64_t kMaxExpansion = 64;
constexpr std::int64_t kExpansionSlack = std::int64_t{1} << 20;

}  // namespace raylign
