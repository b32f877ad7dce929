// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <string>

#include "raylign/base/error.h"
#include "raylign/io/byte_sink.h"
#include "raylign/io/byte_source.h"
#include "raylign/io/compress.h"

namespace raylign::test {
namespace {

namespace fs = std::filesystem;

std::string read_all(ByteSource& source, std::size_t piece) {
  std::string text;
  std::string buffer(piece, '\0');
  while (const std::size_t count = source.read(buffer.data(), piece)) text.append(buffer, 0, count);
  return text;
}

std::string noise(std::size_t size) {
  std::mt19937 engine(5);
  std::string text(size, '\0');
  for (char& c : text) c = "0123456789 \n"[engine() % 12];
  return text;
}

std::string compress(const std::string& text, Compression compression) {
  std::string bytes;
  auto sink = make_compressor(compression, make_string_sink(&bytes));
  for (std::size_t i = 0; i < text.size(); i += 1000) sink->write(text.substr(i, 1000));
  sink->finish();
  return bytes;
}

fs::path fresh_folder(const char* name) {
  const fs::path folder = fs::path(testing::TempDir()) / name;
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

std::string content(const fs::path& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

class Compressed : public testing::TestWithParam<Compression> {};

TEST_P(Compressed, ComesBackForAnySizeAndPiece) {
  for (const std::size_t size : {std::size_t{1}, std::size_t{1000}, std::size_t{300000}}) {
    const std::string text = noise(size);
    const std::string bytes = compress(text, GetParam());
    EXPECT_EQ(detect_compression(bytes), GetParam());
    for (const std::size_t piece : {std::size_t{7}, std::size_t{4096}, std::size_t{1} << 20}) {
      EXPECT_EQ(read_all(*make_byte_source(bytes, "memory"), piece), text);
    }
  }
}

TEST_P(Compressed, MembersAreJoined) {
  const std::string bytes = compress("one ", GetParam()) + compress("", GetParam()) +
                            compress("two", GetParam()) + std::string(700, '\0');
  EXPECT_EQ(read_all(*make_byte_source(bytes, "memory"), 2), "one two");
}

TEST_P(Compressed, TruncationAndGarbageAreErrors) {
  const std::string bytes = compress(noise(2000), GetParam());
  for (std::size_t size = 4; size < bytes.size(); size += 13) {
    EXPECT_THROW(read_all(*make_byte_source({bytes.data(), size}, "memory"), 100), FormatError);
  }
  EXPECT_THROW(read_all(*make_byte_source(bytes + "garbage", "memory"), 100), FormatError);
}

TEST_P(Compressed, ExpansionIsBounded) {
  const std::string bytes = compress(std::string(1 << 23, ' '), GetParam());
  const auto source = make_byte_source(bytes, "memory");
  EXPECT_FALSE(source->size_is_exact());
  const auto size = static_cast<std::int64_t>(bytes.size());
  EXPECT_EQ(source->max_size(), kMaxExpansion * size + kExpansionSlack);
  EXPECT_THROW(read_all(*source, 1000), FormatError);
}

INSTANTIATE_TEST_SUITE_P(Both, Compressed, testing::Values(Compression::GZIP, Compression::BZIP2));

TEST(ByteSource, PlainMemoryAndFile) {
  const fs::path path = fresh_folder("byte_source") / "plain.txt";
  std::ofstream(path) << "text";
  const auto file = open_byte_source(path.string());
  EXPECT_TRUE(file->size_is_exact());
  EXPECT_EQ(file->max_size(), 4);
  EXPECT_EQ(read_all(*file, 3), "text");
  EXPECT_EQ(read_all(*make_byte_source("x", "memory"), 10), "x");
}

TEST(ByteSource, WhatCannotBeOpened) {
  const fs::path folder = fresh_folder("byte_source_bad");
  std::ofstream(folder / "empty.txt").close();
  EXPECT_THROW(open_byte_source((folder / "missing.txt").string()), FormatError);
  EXPECT_THROW(open_byte_source((folder / "empty.txt").string()), FormatError);
  EXPECT_THROW(open_byte_source(folder.string()), FormatError);
  EXPECT_THROW(make_byte_source("", "memory"), FormatError);
}

TEST(ByteSink, TheTargetAppearsOnlyWhenFinished) {
  const fs::path folder = fresh_folder("byte_sink");
  const fs::path path = folder / "file.txt";
  std::ofstream(path) << "old";
  {
    const auto abandoned = open_byte_sink(path.string());
    abandoned->write("half");
  }
  EXPECT_EQ(content(path), "old");
  const auto sink = open_byte_sink(path.string());
  sink->write("new");
  EXPECT_EQ(content(path), "old");
  sink->finish();
  EXPECT_EQ(content(path), "new");
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1);
}

}  // namespace
}  // namespace raylign::test
