#include <palpate/base/toml_file.h>

#include <algorithm>
#include <limits>

#include <fmt/format.h>
#include <toml++/toml.h>

#include <palpate/base/file.h>
#include <palpate/base/toml_nesting.h>

namespace palpate {
namespace {

/// Largest nesting depth. The parser and its tables recurse once per level, without a limit of their own for
/// keys: a deeper file could overflow the stack.
constexpr std::size_t kMaxNesting = 100;

const void* handle(const toml::node& node) { return &node; }
const toml::node& node_of(const void* handle) { return *static_cast<const toml::node*>(handle); }

std::size_t line_of(const toml::node& node) {
  return std::max<std::size_t>(1, node.source().begin.line);  // an empty file has no line
}

toml::table parse(const std::string& path, std::string_view text) {
  if (const auto line = line_nested_deeper(text, kMaxNesting))
    throw Error("{}: line {}: is nested more than {} deep; flatten it", path, *line, kMaxNesting);
  try {
    return toml::parse(text);
  } catch (const toml::parse_error& error) {
    throw Error("{}: line {}: {}", path, error.source().begin.line, error.description());
  }
}

/// Describes the required number in messages.
std::string number_in(double low, double high) {
  constexpr double kAny = std::numeric_limits<double>::max();
  if (low == -kAny && high == kAny) return "a finite number";
  if (high == kAny) return fmt::format("a number of {} or more", low);
  return fmt::format("a number from {} to {}", low, high);
}

}  // namespace

struct TomlFile::Parsed {
  std::string path;
  toml::table root;

  std::string where(const toml::node& node) const { return fmt::format("{}: line {}", path, line_of(node)); }
};

TomlFile::TomlFile(const std::string& path, std::uint64_t max_bytes)
    : TomlFile(path, read_text_file(path, max_bytes)) {}
TomlFile::TomlFile(const std::string& path, std::string_view text)
    : parsed_(new Parsed{path, parse(path, text)}) {}
TomlFile::~TomlFile() = default;
TomlFile::TomlFile(TomlFile&&) noexcept = default;

const std::string& TomlFile::path() const { return parsed_->path; }
TomlTable TomlFile::root() const { return {*parsed_, handle(parsed_->root)}; }

std::size_t TomlValue::line() const { return line_of(node_of(node_)); }
std::string TomlValue::where() const { return parsed_->where(node_of(node_)); }

bool TomlValue::boolean() const {
  const auto* value = node_of(node_).as_boolean();
  if (value == nullptr) throw must_be("true or false");
  return value->get();
}

std::string TomlValue::text() const {
  const auto* value = node_of(node_).as_string();
  if (value == nullptr) throw must_be("text in quotes");
  return value->get();
}

std::int64_t TomlValue::integer(std::int64_t low, std::int64_t high) const {
  const auto* value = node_of(node_).as_integer();
  if (value == nullptr || value->get() < low || value->get() > high)
    throw must_be(fmt::format("a whole number from {} to {}", low, high));
  return value->get();
}

double TomlValue::number(double low, double high) const {
  const auto value = node_of(node_).value<double>();
  if (!node_of(node_).is_number() || !value || !(*value >= low && *value <= high))
    throw must_be(number_in(low, high));
  return *value;
}

void TomlValue::fill(std::span<double> values, double low, double high) const {
  const toml::array* array = node_of(node_).as_array();
  if (array == nullptr || array->size() != values.size())
    throw must_be(fmt::format("an array of {} numbers", values.size()));
  for (std::size_t k = 0; k < values.size(); ++k)
    values[k] = TomlValue(*parsed_, handle(*array->get(k)), key_).number(low, high);
}

bool TomlValue::is_array() const { return node_of(node_).is_array(); }

std::vector<TomlValue> TomlValue::items() const {
  const toml::array* array = node_of(node_).as_array();
  if (array == nullptr) throw must_be("an array");
  std::vector<TomlValue> items;
  items.reserve(array->size());
  for (const toml::node& item : *array) items.push_back({*parsed_, handle(item), key_});
  return items;
}

TomlTable TomlValue::table() const {
  const toml::table* table = node_of(node_).as_table();
  if (table == nullptr) throw must_be("a table");
  return {*parsed_, handle(*table)};
}

std::vector<TomlTable> TomlValue::tables() const {
  if (!node_of(node_).is_array()) throw must_be(fmt::format("an array of tables, [[{}]]", key_));
  std::vector<TomlTable> tables;
  for (const TomlValue& item : items()) tables.push_back(item.table());
  return tables;
}

std::optional<std::string> TomlValue::scalar() const {
  const toml::node& node = node_of(node_);
  if (const auto* v = node.as_string()) return v->get();
  if (const auto* v = node.as_integer()) return fmt::format("{}", v->get());
  if (const auto* v = node.as_floating_point()) return fmt::format("{}", v->get());
  if (const auto* v = node.as_boolean()) return v->get() ? "true" : "false";
  return std::nullopt;
}

Error TomlValue::must_be(std::string_view expected) const {
  const toml::node& node = node_of(node_);
  const auto is = [&]() -> std::string {
    if (const auto* array = node.as_array()) return fmt::format("an array of {}", array->size());
    if (node.is_table()) return "a table";
    if (const auto value = scalar()) return node.is_string() ? fmt::format("'{}'", *value) : *value;
    return "a date or time";
  };
  return Error("{}: '{}' must be {}, not {}", where(), key_, expected, is());
}

std::size_t TomlTable::line() const { return line_of(node_of(node_)); }
std::string TomlTable::where() const { return parsed_->where(node_of(node_)); }

std::optional<TomlValue> TomlTable::find(std::string_view key) {
  if (std::find(asked_.begin(), asked_.end(), key) == asked_.end()) asked_.emplace_back(key);
  const toml::table& table = *node_of(node_).as_table();
  const auto found = table.find(key);
  if (found == table.end()) return std::nullopt;
  return TomlValue(*parsed_, handle(found->second), found->first.str());
}

TomlValue TomlTable::at(std::string_view key) {
  const auto value = find(key);
  if (!value) throw Error("{}: '{}' is missing", where(), key);
  return *value;
}

std::vector<TomlValue> TomlTable::values() const {
  std::vector<TomlValue> values;
  for (const auto& [key, node] : *node_of(node_).as_table())
    values.push_back(TomlValue(*parsed_, handle(node), key.str()));
  return values;
}

void TomlTable::refuse_others() const {
  for (const TomlValue& value : values()) {
    if (std::find(asked_.begin(), asked_.end(), value.key()) != asked_.end()) continue;
    throw Error("{}: unknown key '{}'; the known keys are {}", value.where(), value.key(),
                fmt::join(asked_, ", "));
  }
}

}  // namespace palpate
