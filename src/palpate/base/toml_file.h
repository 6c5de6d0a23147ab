/// \file
/// TOML reader with validated access; every error names file, line and key.
///
///     const TomlFile file("rubber.toml");
///     TomlTable root = file.root();
///     const double friction = root.at("friction").number(0.0, 10.0);
///     if (const auto name = root.find("name")) ... name->text() ...
///     root.refuse_others();
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/base/error.h>

namespace palpate {

class TomlTable;

/// A parsed file. The values it returns refer to it and must not outlive it.
class TomlFile {
 public:
  /// The parser needs about ten times the size of the file in memory.
  static constexpr std::uint64_t kMaxBytes = 1 << 16;

  /// \throws Error if `path` cannot be read, is larger than `max_bytes`, is nested too deeply or is not valid
  /// TOML.
  explicit TomlFile(const std::string& path, std::uint64_t max_bytes = kMaxBytes);
  /// Parses text in memory. \param path name of the text in messages
  TomlFile(const std::string& path, std::string_view text);
  ~TomlFile();
  TomlFile(TomlFile&&) noexcept;
  TomlFile& operator=(TomlFile&&) = delete;

  const std::string& path() const;
  TomlTable root() const;

  struct Parsed;

 private:
  std::unique_ptr<const Parsed> parsed_;
};

/// Value of a key, or an item of its array. Getters throw Error if the value is not of the requested type or
/// range.
class TomlValue {
 public:
  std::string_view key() const { return key_; }  ///< of an array item: the key of the array
  std::size_t line() const;                      ///< from 1
  std::string where() const;                     ///< "FILE: line N", to begin a message with

  bool boolean() const;
  std::string text() const;
  /// A whole number in [low, high].
  std::int64_t integer(std::int64_t low, std::int64_t high) const;
  /// A finite number in [low, high], with or without a decimal point.
  double number(double low = -kAny, double high = kAny) const;
  /// An array of exactly N such numbers.
  template <std::size_t N>
  std::array<double, N> numbers(double low = -kAny, double high = kAny) const {
    std::array<double, N> values;
    fill(values, low, high);
    return values;
  }

  bool is_array() const;
  std::vector<TomlValue> items() const;  ///< of an array
  TomlTable table() const;
  std::vector<TomlTable> tables() const;  ///< of an array of tables, [[key]]

  /// The value as text if it is a string, number or boolean; numbers read back exactly.
  std::optional<std::string> scalar() const;

  /// Error "FILE: line N: 'KEY' must be EXPECTED, not ACTUAL".
  Error must_be(std::string_view expected) const;

 private:
  friend class TomlTable;
  static constexpr double kAny = std::numeric_limits<double>::max();

  TomlValue(const TomlFile::Parsed& parsed, const void* node, std::string_view key)
      : parsed_(&parsed), node_(node), key_(key) {}
  void fill(std::span<double> values, double low, double high) const;

  const TomlFile::Parsed* parsed_;
  const void* node_;  ///< a toml::node, whose header is for toml_file.cpp alone
  std::string_view key_;
};

/// Table of keys and values. Remembers which keys were requested, so that unknown ones can be rejected.
class TomlTable {
 public:
  std::size_t line() const;   ///< where it begins, from 1
  std::string where() const;  ///< "FILE: line N", to begin a message with

  /// The value of `key`, if present.
  std::optional<TomlValue> find(std::string_view key);
  /// \throws Error if `key` is missing.
  TomlValue at(std::string_view key);
  /// All values, in the order of the keys.
  std::vector<TomlValue> values() const;

  /// \throws Error for a key that neither find() nor at() requested; the message lists the requested ones.
  void refuse_others() const;

 private:
  friend class TomlFile;
  friend class TomlValue;
  TomlTable(const TomlFile::Parsed& parsed, const void* node) : parsed_(&parsed), node_(node) {}

  const TomlFile::Parsed* parsed_;
  const void* node_;  ///< a toml::table
  std::vector<std::string> asked_;
};

}  // namespace palpate
