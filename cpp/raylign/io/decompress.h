// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "raylign/io/byte_source.h"

namespace raylign {

enum class Compression { NONE, GZIP, BZIP2 };

/// By the magic bytes at the start of the content.
Compression detect_compression(std::string_view head);

/// The text inside a gzip (RFC 1952) or bzip2 stream; members that follow each other are joined, as
/// gzip and bzip2 do. Throws FormatError from read() when the stream is corrupt, cut short or a
/// bomb.
std::unique_ptr<ByteSource> make_decompressor(Compression compression,
                                              std::unique_ptr<ByteSource> compressed,
                                              const std::string& name);

}  // namespace raylign
