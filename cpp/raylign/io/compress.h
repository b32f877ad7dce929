// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "raylign/io/byte_sink.h"
#include "raylign/io/decompress.h"

namespace raylign {

/// Compresses on the way into `target`.
std::unique_ptr<ByteSink> make_compressor(Compression compression,
                                          std::unique_ptr<ByteSink> target);

}  // namespace raylign
