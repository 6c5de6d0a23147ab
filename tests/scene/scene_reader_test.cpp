// Scenes read in chunks: every Gaussian once, in order, whatever the format and wherever a chunk ends.
#include <array>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <palpate/base/error.h>
#include <palpate/scene/load_scene.h>
#include <palpate/scene/scene_reader.h>

#include "support/ply_builder.h"
#include "support/temporary_file.h"

namespace palpate::test {
namespace {

using testing::HasSubstr;

constexpr std::size_t kChunk = SceneReader::kChunk;
constexpr std::size_t kCounts[] = {1, kChunk - 1, kChunk, kChunk + 1};

// --- files ------------------------------------------------------------------------------------

/// Numbers of one Gaussian in the order of bare_properties().
using Numbers = std::array<float, 11>;

std::vector<Numbers> random_numbers(std::size_t count) {
  std::mt19937 random(21);
  std::uniform_real_distribution<float> uniform(-3.0F, 3.0F);
  std::vector<Numbers> rows(count);
  for (Numbers& row : rows)
    for (float& number : row) number = uniform(random);
  return rows;
}

/// A header for `count` Gaussians of bare_properties(), with positions of type `position_type`.
PlyFile bare_header(Encoding encoding, std::size_t count, const std::string& position_type = "float") {
  PlyFile file;
  file.encoding = encoding;
  file.properties = bare_properties();
  for (const char* axis : {"x", "y", "z"}) file.property(axis).type = position_type;
  file.rows.resize(count);
  return file;
}

/// A .ply of these Gaussians.
std::string ply_of(Encoding encoding, const std::vector<Numbers>& rows) {
  std::string bytes = bare_header(encoding, rows.size()).header();
  for (const Numbers& row : rows) {
    for (const float number : row) bytes += number_bytes("float", number, encoding);
    if (encoding == Encoding::kAscii) bytes += '\n';
  }
  return bytes;
}

/// A .ply of Gaussians that differ only in their positions, which are doubles.
std::string ply_of(Encoding encoding, const std::vector<Eigen::Vector3d>& positions) {
  std::string rest;
  for (int k = 3; k < 11; ++k) rest += number_bytes("float", 0.25 * k, encoding);
  if (encoding == Encoding::kAscii) rest += '\n';
  std::string bytes = bare_header(encoding, positions.size(), "double").header();
  for (const Eigen::Vector3d& p : positions) {
    for (const double number : p) bytes += number_bytes("double", number, encoding);
    bytes += rest;
  }
  return bytes;
}

/// Far from the origin and, with a step of 0.001, not to be held by single precision.
std::vector<Eigen::Vector3d> georeferenced(std::size_t count) {
  std::vector<Eigen::Vector3d> positions;
  for (std::size_t k = 0; k < count; ++k)
    positions.emplace_back(500000.0 + 0.001 * static_cast<double>(k), 5.4e6, -12.5);
  return positions;
}

// --- what is read -----------------------------------------------------------------------------

void expect_numbers(const GaussianScene& scene, std::size_t i, const Numbers& row) {
  ASSERT_EQ(scene.position[i], Eigen::Vector3f(row[0], row[1], row[2]));
  ASSERT_EQ(scene.opacity[i], row[3]);
  ASSERT_EQ(scene.scale[i], Eigen::Vector3f(row[4], row[5], row[6]));
  ASSERT_EQ(scene.rotation[i], Eigen::Vector4f(row[7], row[8], row[9], row[10]));
}

/// Asks `reader` for all chunks, checks their sizes and ids and that the file ends for good, and calls
/// check(chunk, i, row) for every Gaussian.
template <typename Check>
void expect_chunks(SceneReader& reader, std::size_t count, const Check& check) {
  ASSERT_EQ(reader.count(), count);
  GaussianScene chunk;
  for (std::size_t done = 0; done < count; done += chunk.size()) {
    ASSERT_TRUE(reader.next(chunk));
    ASSERT_EQ(chunk.size(), std::min(kChunk, count - done));
    ASSERT_EQ(chunk.id.size(), chunk.size());
    ASSERT_EQ(chunk.source, reader.description().source);
    for (std::size_t i = 0; i < chunk.size(); ++i) {
      ASSERT_EQ(chunk.id[i], done + i);
      check(chunk, i, done + i);
      if (testing::Test::HasFatalFailure()) return;
    }
  }
  for (int again = 0; again < 2; ++again) {
    EXPECT_FALSE(reader.next(chunk));
    EXPECT_EQ(chunk.size(), 0U);
    EXPECT_TRUE(chunk.id.empty());
  }
}

void expect_same(const GaussianScene& a, const GaussianScene& b) {
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.format, b.format);
  EXPECT_EQ(a.scale_encoding, b.scale_encoding);
  EXPECT_EQ(a.opacity_encoding, b.opacity_encoding);
  EXPECT_EQ(a.sh_degree, b.sh_degree);
  EXPECT_EQ(a.trailing_bytes, b.trailing_bytes);
  EXPECT_EQ(a.origin, b.origin);
  EXPECT_TRUE(a.id == b.id && a.position == b.position && a.scale == b.scale && a.rotation == b.rotation &&
              a.opacity == b.opacity && a.filter_3d == b.filter_3d && a.color == b.color);
}

TEST(SceneReader, HandsOutEveryRowOfAPlyOnceInOrder) {
  const std::vector<Numbers> numbers = random_numbers(2 * kChunk + 3);
  for (const Encoding encoding : kEncodings) {
    for (const std::size_t count : kCounts) {
      SCOPED_TRACE(fmt::format("{} rows, encoding {}", count, static_cast<int>(encoding)));
      const std::vector<Numbers> rows(numbers.begin(), numbers.begin() + static_cast<std::ptrdiff_t>(count));
      const TemporaryFile file(ply_of(encoding, rows), "a.ply");
      expect_chunks(*open_scene(file.path()), count,
                    [&](const GaussianScene& chunk, std::size_t i, std::size_t row) {
                      expect_numbers(chunk, i, rows[row]);
                    });
    }
  }
  const TemporaryFile file(ply_of(Encoding::kLittle, numbers), "a.ply");
  expect_chunks(*open_scene(file.path()), numbers.size(),
                [&](const GaussianScene& chunk, std::size_t i, std::size_t row) {
                  expect_numbers(chunk, i, numbers[row]);
                });
}

TEST(SceneReader, HandsOutEveryRecordOfASplatOnceInOrder) {
  for (const std::size_t count : kCounts) {
    SCOPED_TRACE(count);
    std::string bytes;
    for (std::size_t k = 0; k < count; ++k) {
      const double number = static_cast<double>(k);
      for (const double v : {number, 2.0, 3.0, 0.1, 0.2, 0.3 + number}) bytes += bytes_as<float>(v, false);
      for (const std::size_t v : {k, k + 1, k + 2, k + 3, k + 4, k + 5, k + 6, k + 7})
        bytes += static_cast<char>(v % 256);
    }
    const TemporaryFile file(bytes, "a.splat");
    expect_chunks(
        *open_scene(file.path()), count, [&](const GaussianScene& chunk, std::size_t i, std::size_t row) {
          const auto byte = [&](std::size_t k) { return static_cast<std::uint8_t>((row + k) % 256); };
          ASSERT_EQ(chunk.position[i], Eigen::Vector3f(static_cast<float>(row), 2, 3));
          ASSERT_EQ(chunk.scale[i].z(), static_cast<float>(0.3 + static_cast<double>(row)));
          ASSERT_EQ(chunk.color[i], (std::array{byte(0), byte(1), byte(2)}));
          ASSERT_EQ(chunk.opacity[i], byte(3));
          ASSERT_EQ(chunk.rotation[i].w(), (byte(7) - 128.0F) / 128.0F);
        });
  }
}

TEST(SceneReader, ChunksMakeTheSceneThatIsLoadedWhole) {
  for (const Encoding encoding : kEncodings) {
    PlyFile file = inria_file(5);
    file.encoding = encoding;
    file.properties.push_back({"filter_3D"});
    file.data_after = "\n\n\n";
    const TemporaryFile temporary(file.bytes(), "a.ply");
    const auto reader = open_scene(temporary.path());
    EXPECT_EQ(reader->description().format, load_scene(temporary.path()).format);
    EXPECT_EQ(reader->description().size(), 0U);
    GaussianScene chunk;
    ASSERT_TRUE(reader->next(chunk));
    GaussianScene none;
    ASSERT_FALSE(reader->next(none));
    chunk.trailing_bytes = reader->description().trailing_bytes;
    EXPECT_EQ(chunk.trailing_bytes, 3U);
    EXPECT_EQ(chunk.filter_3d.size(), 5U);
    expect_same(chunk, load_scene(temporary.path()));
  }
}

TEST(SceneReader, AChunkHoldsNothingOfWhatWasInIt) {
  const TemporaryFile splat(std::string(64, '\1'), "a.splat");
  const TemporaryFile ply(ply_of(Encoding::kLittle, random_numbers(1)), "a.ply");
  GaussianScene chunk;
  ASSERT_TRUE(open_scene(splat.path())->next(chunk));
  ASSERT_EQ(chunk.color.size(), 2U);
  ASSERT_TRUE(open_scene(ply.path())->next(chunk));
  EXPECT_EQ(chunk.size(), 1U);
  EXPECT_TRUE(chunk.color.empty());
  EXPECT_EQ(chunk.scale_encoding, ScaleEncoding::kLog);
}

TEST(SceneReader, ReadsTheSameOnOneThreadAndOnSeveral) {
  const TemporaryFile file(ply_of(Encoding::kBig, random_numbers(kChunk + 1000)), "a.ply");
  const auto load = [&](std::size_t threads) {
    const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
    return load_scene(file.path());
  };
  expect_same(load(1), load(4));
}

// --- wide positions ---------------------------------------------------------------------------

TEST(SceneReader, FindsTheOriginOfWidePositionsBeforeTheFirstChunk) {
  const std::vector<Eigen::Vector3d> positions = georeferenced(kChunk + 1);
  for (const Encoding encoding : kEncodings) {
    SCOPED_TRACE(static_cast<int>(encoding));
    const TemporaryFile file(ply_of(encoding, positions), "a.ply");
    const auto reader = open_scene(file.path());
    // The row in the middle, 65536, is at 500065.536; -12.5 is rounded away from zero.
    const Eigen::Vector3d origin(500066, 5.4e6, -13);
    EXPECT_EQ(reader->description().origin, origin);
    expect_chunks(*reader, positions.size(), [&](const GaussianScene& chunk, std::size_t i, std::size_t row) {
      ASSERT_EQ(chunk.origin, origin);
      ASSERT_EQ(chunk.position[i], (positions[row] - origin).cast<float>());
      ASSERT_EQ(chunk.rotation[i][3], 2.5F);
    });
  }
}

TEST(SceneReader, OneWidePositionInTheLastChunkMovesTheOriginOfAll) {
  std::vector<Eigen::Vector3d> positions(kChunk + 1, Eigen::Vector3d(1000, 2000, 3000));
  const TemporaryFile exact(ply_of(Encoding::kLittle, positions), "a.ply");
  EXPECT_EQ(open_scene(exact.path())->description().origin, Eigen::Vector3d::Zero());
  positions.back().x() += 0.0001;
  const TemporaryFile inexact(ply_of(Encoding::kLittle, positions), "a.ply");
  EXPECT_EQ(open_scene(inexact.path())->description().origin, positions.front());
}

// --- broken files -----------------------------------------------------------------------------

/// What load_scene() says about a file. Reading it in chunks must give `sound_chunks` and then say so.
std::string refusal_after(std::size_t sound_chunks, const std::string& bytes) {
  const TemporaryFile file(bytes, "a.ply");
  const auto reader = open_scene(file.path());
  GaussianScene chunk;
  for (std::size_t k = 0; k < sound_chunks; ++k) EXPECT_TRUE(reader->next(chunk));
  const std::string message = message_of<Error>([&] { reader->next(chunk); });
  EXPECT_EQ(message, message_of<Error>([&] { load_scene(file.path()); }));
  return message;
}

TEST(SceneReader, ABrokenRowIsAnErrorOfItsChunk) {
  std::string bytes = ply_of(Encoding::kAscii, random_numbers(kChunk + 1));
  const std::size_t row = bytes.rfind('\n', bytes.size() - 2) + 1;
  bytes.insert(bytes.find(' ', row), "x");
  const std::string message = refusal_after(1, bytes);
  EXPECT_THAT(message, HasSubstr(fmt::format("byte {}: Gaussian {}:", row, kChunk)));
}

TEST(SceneReader, DataBehindTheGaussiansAreCheckedAtTheEnd) {
  for (const Encoding encoding : kEncodings) {
    PlyFile file = inria_file(3);
    file.encoding = encoding;
    file.header_after = "element face 2\nproperty int a\n";
    file.data_after = number_bytes("int", 7, encoding);
    EXPECT_THAT(refusal_after(1, file.bytes()), HasSubstr("element 'face'"));
  }
}

TEST(SceneReader, ABrokenRowOfWidePositionsIsAnErrorOfOpening) {
  std::string bytes = ply_of(Encoding::kAscii, georeferenced(3));
  bytes.insert(bytes.size() - 2, "x");
  const TemporaryFile file(bytes, "a.ply");
  EXPECT_THAT(message_of<Error>([&] { open_scene(file.path()); }), HasSubstr("Gaussian 2: property 'rot_3'"));
}

TEST(SceneReader, NoticesAFileThatShrinksWhileItIsRead) {
  for (const Encoding encoding : kEncodings) {
    const TemporaryFile file(ply_of(encoding, random_numbers(2 * kChunk)), "a.ply");
    const auto reader = open_scene(file.path());
    GaussianScene chunk;
    ASSERT_TRUE(reader->next(chunk));
    std::filesystem::resize_file(file.path(), std::filesystem::file_size(file.path()) / 2);
    EXPECT_THAT(message_of<Error>([&] { reader->next(chunk); }), HasSubstr("changed while it was read"));
  }
}

// --- progress ---------------------------------------------------------------------------------

TEST(SceneReader, ReportsEachPassOverTheFile) {
  for (const Encoding encoding : kEncodings) {
    const TemporaryFile file(ply_of(encoding, georeferenced(kChunk + 1)), "a.ply");
    std::vector<std::pair<std::string, double>> reports;
    load_scene(file.path(), [&](std::string_view stage, double done) { reports.emplace_back(stage, done); });
    const double first = static_cast<double>(kChunk) / static_cast<double>(kChunk + 1);
    EXPECT_THAT(reports, testing::ElementsAre(std::pair("surveying", first), std::pair("surveying", 1.0),
                                              std::pair("reading", first), std::pair("reading", 1.0)));
  }
}

}  // namespace
}  // namespace palpate::test
