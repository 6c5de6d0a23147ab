#include <algorithm>
#include <bit>
#include <charconv>
#include <cstdlib>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/base/line_reader.h>
#include <palpate/scene/ply_rows.h>

namespace palpate {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr ByteOrder kNativeOrder =
    std::endian::native == std::endian::little ? ByteOrder::kLittle : ByteOrder::kBig;

/// Removes the next number from `line`; nothing if there is none or it is not a number.
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

/// Reads the rows as doubles, one at a time.
class AsciiRows final : public PlyRows {
 public:
  explicit AsciiRows(const PlyScene& ply)
      : ply_(ply), lines_(ply.file, ply.header.data_offset), values_(ply.vertex().properties.size()) {
    skip(0, ply.vertex_index);
    // A number and its separator take at least two bytes: a larger count is wrong, and must not cause an
    // allocation.
    if (ply.vertex().count > (lines_.bytes_left() + 1) / (2 * values_.size())) {
      throw Error("{}: byte {}: is too short for {} Gaussians; the file is truncated or its header is wrong",
                  ply.file.path(), ply.file.size(), ply.vertex().count);
    }
  }

  PlyDecoder decoder() const override {
    PlyElement row = ply_.vertex();
    for (PlyProperty& property : row.properties) property.type = PlyType::kFloat64;
    return {row, kNativeOrder};
  }

  void next(std::size_t n, const RowReader::Decode& decode) override {
    for (std::size_t k = 0; k < n; ++k) decode(next_row(), k);
  }

  std::uint64_t finish() override {
    skip(ply_.vertex_index + 1, ply_.header.elements.size());
    return lines_.bytes_left();
  }

 private:
  /// Reads the next row, which is valid until the next call.
  RowBlock next_row() {
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

  std::string_view need_line(const PlyElement& element, std::uint64_t row) {
    const auto line = lines_.next();
    if (!line) {
      throw Error(
          "{}: byte {}: ends before row {} of {} of element '{}'; the file is truncated or its header is "
          "wrong",
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

}  // namespace

std::unique_ptr<PlyRows> open_ascii_rows(const PlyScene& ply) { return std::make_unique<AsciiRows>(ply); }

}  // namespace palpate
