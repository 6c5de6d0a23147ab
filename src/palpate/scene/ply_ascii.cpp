#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/scene/line_reader.h>
#include <palpate/scene/origin_survey.h>
#include <palpate/scene/ply_scene.h>

namespace palpate {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr ByteOrder kNativeOrder =
    std::endian::native == std::endian::little ? ByteOrder::kLittle : ByteOrder::kBig;

/// Takes the next number off `line`; nothing if there is none or it is not a number.
std::optional<double> take_number(std::string_view& line) {
  const std::size_t start = line.find_first_not_of(kBlanks);
  if (start == std::string_view::npos) return std::nullopt;
  const std::size_t end = std::min(line.find_first_of(kBlanks, start), line.size());
  std::string_view word = line.substr(start, end - start);
  line.remove_prefix(end);
  if (word.starts_with('+') && !word.starts_with("+-")) word.remove_prefix(1);
  double value = 0.0;
  const auto [stop, error] = std::from_chars(word.begin(), word.end(), value);
  if (stop != word.end() || error == std::errc::invalid_argument) return std::nullopt;
  if (error == std::errc::result_out_of_range)
    return std::strtod(std::string(word).c_str(), nullptr);  // infinity or zero
  return value;
}

/// The rows of `vertex` in an ASCII file, one after the other.
class AsciiRows {
 public:
  /// In front of the first row. \param ply is kept by reference.
  explicit AsciiRows(const PlyScene& ply)
      : ply_(ply), lines_(ply.file, ply.header.data_offset), values_(ply.vertex().properties.size()) {
    skip(0, ply.vertex_index);
    // A number and its separator take two bytes or more: a count beyond that is a lie, and must not
    // become an allocation.
    if (ply.vertex().count > (lines_.bytes_left() + 1) / (2 * values_.size())) {
      throw Error("{}: byte {}: is too short for {} Gaussians; the file is cut or its header is wrong",
                  ply.file.path(), ply.file.size(), ply.vertex().count);
    }
  }

  /// The next row as a block of doubles, valid until the next call.
  RowBlock next() {
    const PlyElement& vertex = ply_.vertex();
    std::string_view line = need_line(vertex, row_);
    for (std::size_t p = 0; p < values_.size(); ++p) {
      const auto value = take_number(line);
      const PlyProperty& property = vertex.properties[p];
      if (!value || !holds(property.type, *value)) {
        throw Error("{}: byte {}: Gaussian {}: property '{}' is missing or not a {}; the file is damaged",
                    ply_.file.path(), lines_.line_start(), row_, property.name, to_string(property.type));
      }
      values_[p] = *value;
    }
    if (line.find_first_not_of(kBlanks) != std::string_view::npos) {
      throw Error("{}: byte {}: Gaussian {} has more than {} values; the file is damaged", ply_.file.path(),
                  lines_.line_start(), row_, values_.size());
    }
    ++row_;
    return {reinterpret_cast<const char*>(values_.data()), values_.size() * sizeof(double), 1};
  }

  /// Behind the last row: walks over the other elements; returns the bytes left.
  std::uint64_t finish() {
    skip(ply_.vertex_index + 1, ply_.header.elements.size());
    return lines_.bytes_left();
  }

 private:
  std::string_view need_line(const PlyElement& element, std::uint64_t row) {
    const auto line = lines_.next();
    if (!line) {
      throw Error(
          "{}: byte {}: ends before row {} of {} of element '{}'; the file is cut or its header is wrong",
          ply_.file.path(), ply_.file.size(), row, element.count, element.name);
    }
    return *line;
  }

  void skip(std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const PlyElement& element = ply_.header.elements[i];
      for (std::uint64_t row = 0; row < element.count; ++row) need_line(element, row);
    }
  }

  const PlyScene& ply_;
  LineReader lines_;
  std::vector<double> values_;
  std::uint64_t row_ = 0;
};

/// Decodes what AsciiRows::next() returns.
PlyDecoder decoder_of_doubles(PlyElement vertex) {
  for (PlyProperty& property : vertex.properties) property.type = PlyType::kFloat64;
  return {vertex, kNativeOrder};
}

/// The origin of wide positions, for which all rows are read.
Eigen::Vector3d find_origin(const PlyScene& ply, const Progress& progress) {
  const std::uint64_t count = ply.vertex().count;
  const PlyDecoder decoder = decoder_of_doubles(ply.vertex());
  AsciiRows rows(ply);
  OriginSurvey survey(count);
  for (std::uint64_t k = 0; k < count; ++k) {
    survey.add(k, decoder.position(rows.next().bytes));
    if ((k + 1) % SceneReader::kChunk == 0 || k + 1 == count)
      report(progress, kSurveyStage, static_cast<double>(k + 1) / static_cast<double>(count));
  }
  return survey.origin();
}

class AsciiPlyReader final : public SceneReader {
 public:
  AsciiPlyReader(PlyScene ply, GaussianScene description, const Progress& progress)
      : SceneReader(std::move(description), ply.vertex().count, progress), ply_(std::move(ply)) {}

 private:
  void read(std::uint64_t /*first*/, GaussianScene& chunk) override {
    decoder_.size_optional(chunk);
    for (std::size_t k = 0; k < chunk.size(); ++k) decoder_.decode(rows_.next(), chunk, k);
  }

  std::uint64_t read_end() override { return rows_.finish(); }

  PlyScene ply_;
  PlyDecoder decoder_ = decoder_of_doubles(ply_.vertex());
  AsciiRows rows_{ply_};
};

}  // namespace

std::unique_ptr<SceneReader> open_ascii_ply(PlyScene ply, const Progress& progress) {
  GaussianScene description = ply.describe();
  if (ply.layout.wide_positions) description.origin = find_origin(ply, progress);
  return std::make_unique<AsciiPlyReader>(std::move(ply), std::move(description), progress);
}

}  // namespace palpate
