// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause

// fuzz_bal_reader [cases [seed]]: seeded mutations of bytes and tokens of a small valid problem,
// plain and compressed. Checks what bal_reader_fuzzer.cpp checks, and that the reader's live memory
// stays below a small multiple of the input.
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <iterator>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "bal_reader_case.h"
#include "raylign/io/byte_sink.h"
#include "raylign/io/byte_source.h"
#include "raylign/io/compress.h"

// <sanitizer/allocator_interface.h>, which GCC does not ship although its runtime has the
// functions.
extern "C" {
int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*,
                                                                  std::size_t),
                                              void (*free_hook)(const volatile void*));
std::size_t __sanitizer_get_allocated_size(const volatile void* block);
}

namespace {

using raylign::Compression;
using Rng = std::mt19937_64;

// --- Live memory, counted by AddressSanitizer's hooks (operator new, malloc, realloc: all of it)
// -------

std::int64_t g_live = 0;
std::int64_t g_peak = 0;

void on_malloc(const volatile void* /*block*/, std::size_t size) {
  g_live += static_cast<std::int64_t>(size);
  g_peak = std::max(g_peak, g_live);
}

void on_free(const volatile void* block) {
  g_live -= static_cast<std::int64_t>(__sanitizer_get_allocated_size(block));
}

constexpr std::int64_t kMiB = std::int64_t{1} << 20;
constexpr std::int64_t kFactor = 64;
// Compressed: the text may be kMaxExpansion times longer; libbz2 itself holds up to 4 MiB.
std::int64_t memory_bound(Compression compression, std::int64_t size) {
  if (compression == Compression::NONE) return kFactor * size + kMiB;
  const std::int64_t text = raylign::kMaxExpansion * size + raylign::kExpansionSlack;
  return kFactor * text + 8 * kMiB;
}

// --- Inputs
// ---------------------------------------------------------------------------------------------

std::size_t below(Rng& rng, std::size_t count) {
  return count == 0 ? 0 : static_cast<std::size_t>(rng() % count);
}

std::string valid_text(Rng& rng) {
  const int cameras = 1 + static_cast<int>(below(rng, 3));
  const int points = 1 + static_cast<int>(below(rng, 5));
  std::string text = std::to_string(cameras) + " " + std::to_string(points) + " " +
                     std::to_string(cameras * points) + "\n";
  std::normal_distribution<double> normal(0.0, 100.0);
  for (int i = 0; i < cameras * points; ++i) {
    text += std::to_string(i % cameras) + " " + std::to_string(i / cameras) + "     " +
            std::to_string(normal(rng)) + " " + std::to_string(normal(rng)) + "\n";
  }
  for (int i = 0; i < 9 * cameras + 3 * points; ++i) text += std::to_string(normal(rng)) + "\n";
  return text;
}

constexpr std::string_view kHostileTokens[] = {
    "0",
    "1",
    "-1",
    "2147483647",
    "2147483648",
    "4294967296",
    "9223372036854775808",
    "999999999999999999",
    "1e18",
    "1e999",
    "-1e999",
    "1e-999",
    "nan",
    "NAN(1)",
    "inf",
    "-infinity",
    "0x1p3",
    "1,5",
    "1.5",
    "1.",
    ".5",
    ".",
    "-",
    "+",
    "+1",
    "+-1",
    "--1",
    "1e",
    "1e+",
    "1d3",
    "\xEF\xBB\xBF",
    "-0.0",
    "4.9e-324",
    "1.7976931348623157e308",
    "1e308",
    "-1e308",
    "\"",
    "#",
    "\r\n",
    "\n\n\n",
};

struct Token {
  std::size_t begin;
  std::size_t size;
};

std::vector<Token> tokens_of(const std::string& text) {
  constexpr std::string_view kBlanks = " \t\n\v\f\r";
  std::vector<Token> tokens;
  std::size_t begin = text.find_first_not_of(kBlanks);
  while (begin != std::string::npos) {
    const std::size_t end = std::min(text.find_first_of(kBlanks, begin), text.size());
    tokens.push_back({begin, end - begin});
    begin = text.find_first_not_of(kBlanks, end);
  }
  return tokens;
}

void mutate_token(std::string& text, Rng& rng) {
  const std::vector<Token> tokens = tokens_of(text);
  if (tokens.empty()) return;
  // Half of the time in the header, where a wrong number does most.
  const std::size_t range =
      below(rng, 2) == 0 ? std::min<std::size_t>(3, tokens.size()) : tokens.size();
  const Token token = tokens[below(rng, range)];
  switch (below(rng, 5)) {
    case 0:
      text.replace(token.begin, token.size, kHostileTokens[below(rng, std::size(kHostileTokens))]);
      break;
    case 1:
      text.replace(token.begin, token.size, std::to_string(below(rng, 40)));
      break;
    case 2:
      text.replace(token.begin, token.size, std::string(below(rng, 3000), '1'));
      break;
    case 3:
      text.erase(token.begin, token.size);
      break;
    default: {
      const Token other = tokens[below(rng, tokens.size())];
      text.insert(token.begin, text.substr(other.begin, other.size) + " ");
    }
  }
}

void mutate_bytes(std::string& bytes, Rng& rng) {
  const std::size_t position = below(rng, bytes.size() + 1);
  const std::size_t count = 1 + below(rng, 16);
  switch (below(rng, 6)) {
    case 0:
      if (position < bytes.size()) bytes[position] ^= static_cast<char>(1 << below(rng, 8));
      break;
    case 1:
      if (position < bytes.size()) bytes[position] = static_cast<char>(rng());
      break;
    case 2:
      bytes.erase(position, count);
      break;
    case 3:
      bytes.insert(position, bytes.substr(below(rng, bytes.size() + 1), count));
      break;
    case 4:
      bytes.resize(position);
      break;
    default:
      bytes.insert(position, below(rng, 64) == 0 ? 5000 : count, " \n\0\t09"[below(rng, 6)]);
  }
}

std::string compressed(const std::string& text, Compression compression) {
  std::string bytes;
  auto sink = raylign::make_compressor(compression, raylign::make_string_sink(&bytes));
  sink->write(text);
  sink->finish();
  return bytes;
}

struct Case {
  std::string bytes;
  Compression compression = Compression::NONE;
};

Case make_case(Rng& rng) {
  Case result;
  result.bytes = valid_text(rng);
  for (std::size_t n = below(rng, 4); n > 0; --n) {
    below(rng, 2) == 0 ? mutate_token(result.bytes, rng) : mutate_bytes(result.bytes, rng);
  }
  if (below(rng, 8) != 0) return result;
  result.compression = below(rng, 2) == 0 ? Compression::GZIP : Compression::BZIP2;
  result.bytes = compressed(result.bytes, result.compression);
  for (std::size_t n = below(rng, 3); n > 0; --n) mutate_bytes(result.bytes, rng);
  return result;
}

}  // namespace

int main(int argc, char** argv) {
  const long cases = argc > 1 ? std::atol(argv[1]) : 100000;
  const std::uint64_t seed = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 1;
  if (__sanitizer_install_malloc_and_free_hooks(on_malloc, on_free) == 0) return EXIT_FAILURE;
  long accepted = 0;
  double worst_factor = 0.0;
  for (long i = 0; i < cases; ++i) {
    Rng rng(seed * 0x9e3779b97f4a7c15ULL +
            static_cast<std::uint64_t>(i));  // any case alone: seed, i
    const Case input = make_case(rng);
    const auto size = static_cast<std::int64_t>(input.bytes.size());
    const std::int64_t before = g_live;
    g_peak = before;
    const auto problem = read_case(input.bytes);
    const std::int64_t used = g_peak - before;
    if (problem) check_accepted(*problem);
    accepted += problem ? 1 : 0;
    if (used > memory_bound(input.compression, size)) {
      std::fprintf(stderr, "seed %llu case %ld: %lld bytes of memory for %lld bytes of input\n",
                   static_cast<unsigned long long>(seed), i, static_cast<long long>(used),
                   static_cast<long long>(size));
      return EXIT_FAILURE;
    }
    if (input.compression == Compression::NONE) {
      const auto beyond_buffers = static_cast<double>(std::max<std::int64_t>(0, used - kMiB / 2));
      worst_factor = std::max(worst_factor, beyond_buffers / static_cast<double>(size + 1));
    }
  }
  std::printf("%ld cases, %ld accepted, %ld refused; plain: 0.5 MiB + at most %.1f x input\n",
              cases, accepted, cases - accepted, worst_factor);
  return EXIT_SUCCESS;
}
