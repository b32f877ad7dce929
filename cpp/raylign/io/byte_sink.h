// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <string_view>

namespace raylign {

/// Where a writer puts its bytes. Nothing counts as written before finish() returned.
class ByteSink {
 public:
  virtual ~ByteSink() = default;
  /// Throws FormatError when the bytes cannot be stored.
  virtual void write(std::string_view bytes) = 0;
  virtual void finish() = 0;
  /// For messages.
  virtual const std::string& name() const = 0;
};

/// Writes beside `path` and renames in finish(): until then, and after any failure, the old file is
/// as it was and no temporary file stays behind. A path that ends in .gz or .bz2 is compressed
/// (reproducibly: no time stamp). Links are followed; a pipe or device is written directly.
std::unique_ptr<ByteSink> open_byte_sink(const std::string& path);

/// Appends to `*text`, which must outlive the sink.
std::unique_ptr<ByteSink> make_string_sink(std::string* text);

}  // namespace raylign
