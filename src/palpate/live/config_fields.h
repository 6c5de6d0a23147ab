/// \file
/// Table of all fields of a LiveConfig, the single source of command-line options, file keys and parameters.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include <palpate/live/live_config.h>

namespace palpate {

/// Groups of fields, used as headings.
enum class ConfigGroup : std::uint8_t { kScene, kTool, kForce, kDevice, kLoop, kGateway, kRoom };
std::string_view title(ConfigGroup group);

/// Accessor of a member of LiveConfig.
template <class T>
class ConfigMember {
 public:
  /// \param Field a captureless lambda that returns a reference to the value, of a const or non-const
  /// configuration.
  template <class Field>
  requires std::is_empty_v<Field>
  constexpr ConfigMember(Field)  // NOLINT(google-explicit-constructor): it is written as a lambda
      : read_([](const LiveConfig& config) -> const T& { return Field{}(config); }),
        write_([](LiveConfig& config) -> T& { return Field{}(config); }) {}

  const T& operator()(const LiveConfig& config) const { return read_(config); }
  T& operator()(LiveConfig& config) const { return write_(config); }

 private:
  const T& (*read_)(const LiveConfig&);
  T& (*write_)(LiveConfig&);
};

/// \name Types of fields
/// @{
struct FlagField {
  ConfigMember<bool> member;
};
struct TextField {
  ConfigMember<std::string> member;
  std::string (*problem)(std::string_view text) = nullptr;  ///< returns why a text is invalid; empty: valid
};
/// An integer in [least, most]; a default outside this range means "not set".
struct CountField {
  ConfigMember<int> member;
  int least, most;
};
struct NumberField {
  ConfigMember<double> member;
  double least, most;  ///< both included
};
/// A positive number below `below`, or none.
struct OptionalField {
  ConfigMember<std::optional<double>> member;
  double below = std::numeric_limits<double>::infinity();
  double most_parameter = 0.0;  ///< upper limit as a parameter, for which 0 means none
};
struct ChoiceField {
  std::vector<std::string_view> names;
  std::size_t (*get)(const LiveConfig& config);  ///< index into `names`
  void (*set)(LiveConfig& config, std::size_t choice);
  /// If other text is accepted too: the member that holds it (empty: one of `names` is chosen), and the
  /// predicate `may_be` that accepts it.
  std::optional<ConfigMember<std::string>> other = std::nullopt;
  bool (*may_be)(const std::string& text) = nullptr;

  /// Returns the chosen name or other text; empty if neither is set.
  std::string_view chosen(const LiveConfig& config) const {
    if (other && !(*other)(config).empty()) return (*other)(config);
    const std::size_t choice = get(config);
    return choice < names.size() ? names[choice] : std::string_view();
  }
};
/// A fixed number of related numbers.
struct NumbersField {
  std::size_t count;
  std::vector<double> (*get)(const LiveConfig& config);  ///< empty: not set
  void (*set)(LiveConfig& config,
              const std::vector<double>& all);  ///< \throws BadValue. \pre `all` has `count` numbers
  bool shows_default = false;
  bool unit_norm = false;       ///< a quaternion: text is normalized, a value of LiveConfig must be
  double most_parameter = 0.0;  ///< limit of each magnitude, as a parameter
  void (*unset)(LiveConfig& config) = nullptr;  ///< what an empty parameter does; null: it is refused
};
struct ToolField {
  ConfigMember<Tool> member;
};
using FieldType = std::variant<FlagField, TextField, CountField, NumberField, OptionalField, ChoiceField,
                               NumbersField, ToolField>;
/// @}

/// Additional properties of a field.
struct FieldTraits {
  bool saved = false;                   ///< a setting that a user tunes and keeps, see TomlFields::kSaved
  bool read_only = false;               ///< as a parameter
  std::string_view excludes = {};       ///< name of the field that it replaces when set
  std::string_view shown_default = {};  ///< for display, if different from the value
};

/// Description of one field.
struct ConfigField {
  std::string_view name;       ///< key in TOML, long command-line option; empty: has neither
  std::string_view parameter;  ///< name in JSON, levels separated by dots; empty: not a parameter
  ConfigGroup group;
  std::string_view unit;  ///< or placeholder for a non-numeric value
  std::string_view help;
  FieldType type;
  FieldTraits traits = {};
};

/// Returns all fields except SceneConfig::path, in the order of their groups' members, as in --help and
/// files.
std::span<const ConfigField> config_fields();
/// Returns the field with that name. \throws Error if there is none.
const ConfigField& config_field(std::string_view name);

/// Sets a field from text, with numbers separated by commas. \throws BadValue, or Error for a tool's file.
void set_from_text(const ConfigField& field, LiveConfig& config, const std::string& text);
/// Checks that every field has a value that set_from_text() could set, or its default, and that rotations are
/// unit quaternions. \throws Error that names the first field that has not.
void check_config(const LiveConfig& config);
/// Returns the default as displayed to the user; empty: none.
std::string default_text(const ConfigField& field, const LiveConfig& config);

}  // namespace palpate
