#include <palpate/scene/ply_header.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <utility>

#include <palpate/base/error.h>

namespace palpate {
namespace {

constexpr std::uint64_t kMaxHeaderBytes = std::uint64_t{1} << 20;
constexpr std::uint64_t kUsualHeaderBytes = std::uint64_t{1} << 14;
// Real scenes have a handful of elements and up to about a hundred properties; a hostile header must
// not cost quadratic time.
constexpr std::size_t kMaxElements = 100;
constexpr std::size_t kMaxProperties = 1000;

struct TypeInfo {
  std::string_view old_name;  ///< of the 1994 format description
  std::string_view name;
  std::size_t bytes;
  double lowest, highest;  ///< of the integer types
};

constexpr std::array<TypeInfo, 8> kTypes{{{"char", "int8", 1, -128, 127},
                                          {"uchar", "uint8", 1, 0, 255},
                                          {"short", "int16", 2, -32768, 32767},
                                          {"ushort", "uint16", 2, 0, 65535},
                                          {"int", "int32", 4, -2147483648.0, 2147483647.0},
                                          {"uint", "uint32", 4, 0, 4294967295.0},
                                          {"float", "float32", 4, 0, 0},
                                          {"double", "float64", 8, 0, 0}}};

const TypeInfo& info(PlyType type) { return kTypes[static_cast<std::size_t>(type)]; }

/// Splits a line at blanks.
std::vector<std::string_view> words_of(std::string_view line) {
  std::vector<std::string_view> words;
  std::size_t at = 0;
  while ((at = line.find_first_not_of(" \t", at)) != std::string_view::npos) {
    const std::size_t end = std::min(line.find_first_of(" \t", at), line.size());
    words.push_back(line.substr(at, end - at));
    at = end;
  }
  return words;
}

/// Parses a header line by line.
class HeaderParser {
 public:
  HeaderParser(const InputFile& file, std::string_view text) : file_(file), text_(text) {}

  PlyHeader parse() {
    next_line();  // "ply", checked by is_ply()
    for (;;) {
      const auto words = words_of(next_line());
      if (words.empty() || words[0] == "comment" || words[0] == "obj_info") continue;
      if (words[0] == "end_header") break;
      if (words[0] == "format") {
        parse_format(words);
      } else if (words[0] == "element") {
        parse_element(words);
      } else if (words[0] == "property") {
        parse_property(words);
      } else {
        fail("unknown keyword '{}'", words[0]);
      }
    }
    if (!has_format_) fail("the header ends without a format line");
    header_.data_offset = at_;
    return std::move(header_);
  }

 private:
  template <typename... Args>
  [[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) const {
    throw Error("{}: header line {}: {}; the file is damaged or not a .ply", file_.path(), line_number_,
                fmt::format(format, std::forward<Args>(args)...));
  }

  std::string_view next_line() {
    ++line_number_;
    const std::size_t end = text_.find('\n', at_);
    if (end == std::string_view::npos) {
      if (text_.size() < file_.size()) fail("no end_header in the first {} bytes", text_.size());
      fail("the file ends at byte {} without end_header", text_.size());
    }
    std::string_view line = text_.substr(at_, end - at_);
    at_ = end + 1;
    if (line.ends_with('\r')) line.remove_suffix(1);
    return line;
  }

  void parse_format(const std::vector<std::string_view>& words) {
    if (has_format_) fail("a second format line");
    if (words.size() != 3 || words[2] != "1.0") fail("the format line is not 'format ENCODING 1.0'");
    has_format_ = true;
    for (const auto encoding :
         {PlyEncoding::kAscii, PlyEncoding::kBinaryLittleEndian, PlyEncoding::kBinaryBigEndian}) {
      if (words[1] == to_string(encoding)) {
        header_.encoding = encoding;
        return;
      }
    }
    fail("unknown encoding '{}'", words[1]);
  }

  void parse_element(const std::vector<std::string_view>& words) {
    if (words.size() != 3) fail("the element line is not 'element NAME COUNT'");
    std::uint64_t count = 0;
    const auto [end, error] = std::from_chars(words[2].begin(), words[2].end(), count);
    if (error != std::errc{} || end != words[2].end()) fail("'{}' is not a count", words[2]);
    for (const PlyElement& e : header_.elements) {
      if (e.name == words[1]) fail("a second element '{}'", words[1]);
    }
    if (header_.elements.size() == kMaxElements) fail("more than {} elements", kMaxElements);
    header_.elements.push_back({std::string(words[1]), count, {}});
  }

  void parse_property(const std::vector<std::string_view>& words) {
    if (header_.elements.empty()) fail("a property before the first element");
    PlyElement& element = header_.elements.back();
    if (element.properties.size() == kMaxProperties) fail("more than {} properties", kMaxProperties);
    const bool list = words.size() == 5 && words[1] == "list";
    if (!list && words.size() != 3) fail("the property line is not 'property TYPE NAME'");
    PlyProperty property{std::string(words.back()), parse_type(words[list ? 3 : 1]), {}};
    if (list) property.list_length = parse_type(words[2]);
    if (element.find(property.name)) fail("a second property '{}'", property.name);
    element.properties.push_back(std::move(property));
  }

  PlyType parse_type(std::string_view word) const {
    for (std::size_t i = 0; i < kTypes.size(); ++i) {
      if (word == kTypes[i].old_name || word == kTypes[i].name) return static_cast<PlyType>(i);
    }
    fail("unknown type '{}'", word);
  }

  const InputFile& file_;
  std::string_view text_;
  std::size_t at_ = 0;
  int line_number_ = 0;
  bool has_format_ = false;
  PlyHeader header_{};
};

}  // namespace

std::size_t size_of(PlyType type) { return info(type).bytes; }

const char* to_string(PlyType type) { return info(type).name.data(); }

double load_number(const char* bytes, PlyType type, ByteOrder order) {
  return with_type(type,
                   [&](auto kind) { return static_cast<double>(load_as<decltype(kind)>(bytes, order)); });
}

bool holds(PlyType type, double value) {
  if (type == PlyType::kFloat32 || type == PlyType::kFloat64) return true;
  return value >= info(type).lowest && value <= info(type).highest && value == std::floor(value);
}

std::optional<std::size_t> PlyElement::stride() const {
  std::size_t bytes = 0;
  for (const PlyProperty& property : properties) {
    if (property.list_length) return std::nullopt;
    bytes += size_of(property.type);
  }
  return bytes;
}

std::optional<std::size_t> PlyElement::find(std::string_view name_) const {
  for (std::size_t i = 0; i < properties.size(); ++i) {
    if (properties[i].name == name_) return i;
  }
  return std::nullopt;
}

const char* to_string(PlyEncoding encoding) {
  switch (encoding) {
    case PlyEncoding::kAscii: return "ascii";
    case PlyEncoding::kBinaryLittleEndian: return "binary_little_endian";
    case PlyEncoding::kBinaryBigEndian: return "binary_big_endian";
  }
  return "?";
}

bool is_ply(std::string_view start) { return start.starts_with("ply\n") || start.starts_with("ply\r"); }

PlyHeader read_ply_header(const InputFile& file) {
  std::string text;
  for (const std::uint64_t most : {kUsualHeaderBytes, kMaxHeaderBytes}) {
    text.resize(std::min(file.size(), most));
    text.resize(file.read_some(0, text));
    const std::size_t end = text.find("\nend_header");
    if (end != std::string::npos && text.find('\n', end + 1) != std::string::npos) break;
  }
  return HeaderParser(file, text).parse();
}

}  // namespace palpate
