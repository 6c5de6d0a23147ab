#include <palpate/scene/ply_reader.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include <palpate/base/error.h>
#include <palpate/base/quantile.h>
#include <palpate/scene/sh_color.h>

namespace palpate {
namespace {

constexpr std::size_t kChunkBytes = std::size_t{8} << 20;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// What is read of a row; the index of a value in Row.
enum Field {
  kX,
  kY,
  kZ,
  kScale0,
  kScale1,
  kScale2,
  kRot0,
  kRot1,
  kRot2,
  kRot3,
  kOpacity,
  kFilter,
  kRed,
  kGreen,
  kBlue,
  kFieldCount
};
constexpr std::array<const char*, kFieldCount> kFieldNames{
    "x",     "y",     "z",       "scale_0",   "scale_1", "scale_2", "rot_0", "rot_1",
    "rot_2", "rot_3", "opacity", "filter_3D", "f_dc_0",  "f_dc_1",  "f_dc_2"};
using Row = std::array<double, kFieldCount>;

/// Which property of the element holds each field, if any does.
using Columns = std::array<std::optional<std::size_t>, kFieldCount>;

/// Checks that the element is a Gaussian splatting scene and finds its columns.
class Layout {
 public:
  Layout(const std::string& path, const PlyElement& vertex) : path_(path), vertex_(vertex) {
    for (std::size_t f = 0; f < kFieldCount; ++f) columns_[f] = vertex.find(kFieldNames[f]);
    if (vertex.find("packed_position")) {
      throw Error(
          "{}: is a compressed .ply (property 'packed_position'), which cannot be read; convert it to plain "
          ".ply first",
          path);
    }
    for (const Field field : {kX, kY, kZ, kOpacity, kScale0, kScale1, kRot0, kRot1, kRot2, kRot3}) {
      if (!columns_[field]) {
        throw Error("{}: property '{}' of element 'vertex' is missing; it is not a Gaussian splatting scene",
                    path, kFieldNames[field]);
      }
    }
    for (const auto& column : columns_) {
      if (column && vertex.properties[*column].list_length) {
        throw Error("{}: property '{}' is a list; it must be one number", path,
                    vertex.properties[*column].name);
      }
    }
    if (has(kRed) != has(kGreen) || has(kRed) != has(kBlue)) {
      throw Error("{}: has some of the properties f_dc_0, f_dc_1, f_dc_2 but not all; the file is damaged",
                  path);
    }
    sh_degree_ = find_sh_degree();
  }

  const Columns& columns() const { return columns_; }
  bool has(Field field) const { return columns_[field].has_value(); }
  int sh_degree() const { return sh_degree_; }

  /// True if a position may not fit single precision.
  bool wide_positions() const {
    return std::any_of(columns_.begin(), columns_.begin() + 3, [&](const auto& column) {
      const PlyType type = vertex_.properties[*column].type;
      return type == PlyType::kFloat64 || type == PlyType::kInt32 || type == PlyType::kUint32;
    });
  }

 private:
  int find_sh_degree() const {
    const auto is_rest = [](const PlyProperty& p) { return p.name.starts_with("f_rest_"); };
    const auto count =
        static_cast<int>(std::count_if(vertex_.properties.begin(), vertex_.properties.end(), is_rest));
    for (int degree = 0; degree <= 4; ++degree) {
      if (count != 3 * ((degree + 1) * (degree + 1) - 1)) continue;
      for (int k = 0; k < count; ++k) {
        if (!vertex_.find("f_rest_" + std::to_string(k))) {
          throw Error("{}: property 'f_rest_{}' is missing among {} of its kind; the file is damaged", path_,
                      k, count);
        }
      }
      return degree;
    }
    throw Error(
        "{}: has {} properties f_rest_*, which is no SH degree (0, 9, 24, 45 or 72); the file is damaged",
        path_, count);
  }

  const std::string& path_;
  const PlyElement& vertex_;
  Columns columns_;
  int sh_degree_ = 0;
};

/// Collects rows into a scene.
class SceneBuilder {
 public:
  SceneBuilder(GaussianScene& scene, const Layout& layout, std::size_t count)
      : scene_(scene), layout_(layout), wide_(layout.wide_positions()) {
    scene_.reserve(count);
    if (wide_) wide_positions_.reserve(count);
    if (layout.has(kFilter)) scene_.filter_3d.reserve(count);
  }

  void add(const Row& row) {
    const auto number = [&](Field field) { return static_cast<float>(row[field]); };
    scene_.id.push_back(static_cast<std::uint32_t>(scene_.id.size()));
    if (wide_) {
      wide_positions_.emplace_back(row[kX], row[kY], row[kZ]);
    } else {
      scene_.position.emplace_back(number(kX), number(kY), number(kZ));
    }
    scene_.scale.emplace_back(number(kScale0), number(kScale1), number(kScale2));
    scene_.rotation.emplace_back(number(kRot0), number(kRot1), number(kRot2), number(kRot3));
    scene_.opacity.push_back(number(kOpacity));
    if (layout_.has(kFilter)) scene_.filter_3d.push_back(number(kFilter));
    if (layout_.has(kRed))
      scene_.color.push_back(
          {color_from_sh(row[kRed]), color_from_sh(row[kGreen]), color_from_sh(row[kBlue])});
  }

  /// Rounds wide positions to single precision, relative to an origin among them if that loses less.
  void finish() {
    if (!wide_) return;
    const auto exact = [](const Eigen::Vector3d& p) {
      return !p.allFinite() || p.cast<float>().cast<double>() == p;
    };
    if (!std::all_of(wide_positions_.begin(), wide_positions_.end(), exact)) scene_.origin = middle();
    for (const Eigen::Vector3d& p : wide_positions_) {
      scene_.position.push_back((p - scene_.origin).cast<float>());
    }
  }

 private:
  /// The median of each coordinate, which no stray Gaussian moves, in whole units, which are exact
  /// to add back.
  Eigen::Vector3d middle() const {
    Eigen::Vector3d result;
    for (int axis = 0; axis < 3; ++axis) {
      std::vector<double> values;
      values.reserve(wide_positions_.size());
      for (const Eigen::Vector3d& p : wide_positions_) {
        if (std::abs(p[axis]) <= kMaxExtent) values.push_back(p[axis]);
      }
      result[axis] = std::round(quantile(values, 0.5));
    }
    return result;
  }

  GaussianScene& scene_;
  const Layout& layout_;
  bool wide_;
  std::vector<Eigen::Vector3d> wide_positions_;
};

Row blank_row() {
  Row row{};
  row[kScale2] = -kInfinity;  // the log of a sigma of zero
  return row;
}

// --- binary ---------------------------------------------------------------------------------

/// Byte after `element`, whose data begin at `offset`. Rows with lists are walked through.
std::uint64_t skip_binary(const InputFile& file, const PlyElement& element, ByteOrder order,
                          std::uint64_t offset) {
  const auto ends_early = [&]() -> Error {
    return Error("{}: byte {}: ends inside element '{}'; the file is cut or its header is wrong", file.path(),
                 file.size(), element.name);
  };
  if (const auto stride = element.stride()) {
    if (*stride != 0 && element.count > (file.size() - offset) / *stride) throw ends_early();
    return offset + element.count * *stride;
  }
  for (std::uint64_t row = 0; row < element.count; ++row) {
    for (const PlyProperty& property : element.properties) {
      std::uint64_t bytes = size_of(property.type);
      if (property.list_length) {
        std::array<char, 8> raw{};
        const std::size_t head = size_of(*property.list_length);
        if (head > file.size() - offset) throw ends_early();
        file.read(offset, {raw.data(), head});
        offset += head;
        const double items = load_number(raw.data(), *property.list_length, order);
        if (!(items >= 0.0 && items <= static_cast<double>(file.size()))) {
          throw Error("{}: byte {}: list '{}' claims {} items; the file is damaged", file.path(),
                      offset - head, property.name, items);
        }
        bytes *= static_cast<std::uint64_t>(items);
      }
      if (bytes > file.size() - offset) throw ends_early();
      offset += bytes;
    }
  }
  return offset;
}

/// Reads the rows of `vertex` at `offset`; returns the byte after them.
std::uint64_t read_binary_rows(const InputFile& file, const PlyElement& vertex, ByteOrder order,
                               std::uint64_t offset, const Columns& columns, SceneBuilder& builder,
                               const Progress& progress) {
  const std::size_t stride = *vertex.stride();
  struct Source {
    Field field;
    std::size_t offset;
    PlyType type;
  };
  std::vector<Source> sources;
  for (std::size_t f = 0; f < kFieldCount; ++f) {
    if (!columns[f]) continue;
    std::size_t at = 0;
    for (std::size_t p = 0; p < *columns[f]; ++p) at += size_of(vertex.properties[p].type);
    sources.push_back({static_cast<Field>(f), at, vertex.properties[*columns[f]].type});
  }
  const std::uint64_t rows_per_chunk = std::max<std::uint64_t>(1, kChunkBytes / stride);
  std::vector<char> chunk(std::min(rows_per_chunk, vertex.count) * stride);
  Row row = blank_row();
  for (std::uint64_t done = 0; done < vertex.count;) {
    const std::uint64_t n = std::min(rows_per_chunk, vertex.count - done);
    file.read(offset + done * stride, {chunk.data(), n * stride});
    for (std::uint64_t k = 0; k < n; ++k) {
      const char* bytes = chunk.data() + k * stride;
      for (const Source& source : sources)
        row[source.field] = load_number(bytes + source.offset, source.type, order);
      builder.add(row);
    }
    done += n;
    report(progress, "reading", static_cast<double>(done) / static_cast<double>(vertex.count));
  }
  return offset + vertex.count * stride;
}

void read_binary(const InputFile& file, const PlyHeader& header, const PlyElement& vertex,
                 const Layout& layout, GaussianScene& scene, const Progress& progress) {
  const ByteOrder order =
      header.encoding == PlyEncoding::kBinaryBigEndian ? ByteOrder::kBig : ByteOrder::kLittle;
  std::uint64_t offset = header.data_offset;
  for (const PlyElement& element : header.elements) {
    if (&element != &vertex) {
      offset = skip_binary(file, element, order, offset);
      continue;
    }
    const auto stride = vertex.stride();
    if (!stride)
      throw Error("{}: element 'vertex' has a list property; rows of one size are needed", file.path());
    const std::uint64_t whole_rows = (file.size() - offset) / *stride;
    if (vertex.count > whole_rows) {
      throw Error("{}: byte {}: ends inside Gaussian {} of {}; the file is cut or its header is wrong",
                  file.path(), file.size(), whole_rows, vertex.count);
    }
    SceneBuilder builder(scene, layout, vertex.count);
    offset = read_binary_rows(file, vertex, order, offset, layout.columns(), builder, progress);
    builder.finish();
  }
  scene.trailing_bytes = file.size() - offset;
}

// --- ASCII ----------------------------------------------------------------------------------

/// Hands out the lines of a text file from an offset on, without their terminators.
class LineReader {
 public:
  LineReader(const InputFile& file, std::uint64_t offset)
      : file_(file), next_read_(offset), line_start_(offset) {}

  /// The next line that is not blank; nothing at the end of the file.
  std::optional<std::string_view> next() {
    for (;;) {
      const std::size_t end = buffer_.find('\n', at_);
      if (end == std::string::npos && refill()) continue;
      if (at_ == buffer_.size()) return std::nullopt;
      const std::size_t length = std::min(end, buffer_.size()) - at_;
      const std::string_view line(buffer_.data() + at_, length);
      line_start_ = next_read_ - (buffer_.size() - at_);
      at_ = std::min(at_ + length + 1, buffer_.size());
      if (line.find_first_not_of(" \t\r") != std::string_view::npos) return line;
    }
  }

  /// Byte offset in the file of the line last handed out.
  std::uint64_t line_start() const { return line_start_; }
  /// Bytes of the file behind that line.
  std::uint64_t bytes_left() const { return file_.size() - next_read_ + (buffer_.size() - at_); }

 private:
  bool refill() {
    if (next_read_ >= file_.size()) return false;
    if (buffer_.size() - at_ > kMaxLineBytes) {
      throw Error("{}: byte {}: a line of over {} bytes; the file is damaged", file_.path(),
                  next_read_ - (buffer_.size() - at_), kMaxLineBytes);
    }
    buffer_.erase(0, at_);
    at_ = 0;
    const std::size_t old = buffer_.size();
    buffer_.resize(old + std::min<std::uint64_t>(kReadBytes, file_.size() - next_read_));
    file_.read(next_read_, {buffer_.data() + old, buffer_.size() - old});
    next_read_ += buffer_.size() - old;
    return true;
  }

  static constexpr std::size_t kReadBytes = std::size_t{1} << 20;
  static constexpr std::size_t kMaxLineBytes = std::size_t{16} << 20;
  const InputFile& file_;
  std::string buffer_;
  std::size_t at_ = 0;
  std::uint64_t next_read_;
  std::uint64_t line_start_;
};

/// Takes the next number off `line`; nothing if there is none or it is not a number.
std::optional<double> take_number(std::string_view& line) {
  const std::size_t start = line.find_first_not_of(" \t\r");
  if (start == std::string_view::npos) return std::nullopt;
  const std::size_t end = std::min(line.find_first_of(" \t\r", start), line.size());
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

void read_ascii(const InputFile& file, const PlyHeader& header, const PlyElement& vertex,
                const Layout& layout, GaussianScene& scene, const Progress& progress) {
  LineReader lines(file, header.data_offset);
  const auto need_line = [&](const PlyElement& element, std::uint64_t row) {
    const auto line = lines.next();
    if (!line) {
      throw Error(
          "{}: byte {}: ends before row {} of {} of element '{}'; the file is cut or its header is wrong",
          file.path(), file.size(), row, element.count, element.name);
    }
    return *line;
  };
  const auto skip_others = [&](const PlyElement* first, const PlyElement* last) {
    for (const PlyElement* element = first; element != last; ++element) {
      for (std::uint64_t row = 0; row < element->count; ++row) need_line(*element, row);
    }
  };
  skip_others(header.elements.data(), &vertex);
  // A number and its separator take two bytes or more: a count beyond that is a lie, and must not
  // become an allocation.
  if (vertex.count > (lines.bytes_left() + 1) / (2 * vertex.properties.size())) {
    throw Error("{}: byte {}: is too short for {} Gaussians; the file is cut or its header is wrong",
                file.path(), file.size(), vertex.count);
  }
  SceneBuilder builder(scene, layout, vertex.count);
  std::vector<double> values(vertex.properties.size());
  Row row = blank_row();
  constexpr std::uint64_t kRowsPerReport = 1 << 16;
  for (std::uint64_t k = 0; k < vertex.count; ++k) {
    std::string_view line = need_line(vertex, k);
    for (std::size_t p = 0; p < values.size(); ++p) {
      const auto value = take_number(line);
      const PlyProperty& property = vertex.properties[p];
      if (!value || !holds(property.type, *value)) {
        throw Error("{}: byte {}: Gaussian {}: property '{}' is missing or not a {}; the file is damaged",
                    file.path(), lines.line_start(), k, property.name, to_string(property.type));
      }
      values[p] = *value;
    }
    if (line.find_first_not_of(" \t\r") != std::string_view::npos) {
      throw Error("{}: byte {}: Gaussian {} has more than {} values; the file is damaged", file.path(),
                  lines.line_start(), k, values.size());
    }
    for (std::size_t f = 0; f < kFieldCount; ++f) {
      if (layout.columns()[f]) row[f] = values[*layout.columns()[f]];
    }
    builder.add(row);
    if (k % kRowsPerReport == 0)
      report(progress, "reading", static_cast<double>(k) / static_cast<double>(vertex.count));
  }
  builder.finish();
  skip_others(&vertex + 1, header.elements.data() + header.elements.size());
  scene.trailing_bytes = lines.bytes_left();
}

const PlyElement& find_vertex(const InputFile& file, const PlyHeader& header) {
  for (const PlyElement& element : header.elements) {
    if (element.name != "vertex") continue;
    if (element.count == 0)
      throw Error("{}: holds no Gaussians ('element vertex 0'); train or export it again", file.path());
    if (element.count > std::numeric_limits<std::uint32_t>::max()) {
      throw Error(
          "{}: claims {} Gaussians, more than 32-bit ids can count; the header is wrong or the file must be "
          "split",
          file.path(), element.count);
    }
    return element;
  }
  throw Error("{}: has no element 'vertex'; it is not a Gaussian splatting scene", file.path());
}

}  // namespace

GaussianScene read_ply(const InputFile& file, const Progress& progress) {
  const PlyHeader header = read_ply_header(file);
  const PlyElement& vertex = find_vertex(file, header);
  const Layout layout(file.path(), vertex);

  GaussianScene scene;
  scene.source = file.path();
  scene.sh_degree = layout.sh_degree();
  const char* variant = layout.has(kFilter) ? "Mip-Splatting" : layout.has(kScale2) ? "INRIA" : "2DGS";
  scene.format =
      fmt::format("{} .ply, {}, SH degree {}", variant, to_string(header.encoding), scene.sh_degree);
  if (header.encoding == PlyEncoding::kAscii) {
    read_ascii(file, header, vertex, layout, scene, progress);
  } else {
    read_binary(file, header, vertex, layout, scene, progress);
  }
  report(progress, "reading", 1.0);
  return scene;
}

}  // namespace palpate
