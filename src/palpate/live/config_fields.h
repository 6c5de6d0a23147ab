/// \file
/// Description of every field of a LiveConfig: the one table that options, files and parameters are made
/// from.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include <palpate/live/live_config.h>

namespace palpate {

/// Headings that fields are listed under.
enum class ConfigGroup : std::uint8_t { kScene, kTool, kForce, kDevice, kLoop, kGateway, kRoom };
std::string_view title(ConfigGroup group);

/// Where a value is in a configuration.
template <class T>
class ConfigMember {
 public:
  /// \param Field a lambda without captures that gives the place of the value, of a constant configuration,
  /// too.
  template <class Field>
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
  std::string (*problem)(std::string_view text) = nullptr;  ///< why it is refused; empty: it is not
};
/// A whole number from `least` to `most`; a default outside means that it is not set.
struct CountField {
  ConfigMember<int> member;
  int least, most;
};
struct NumberField {
  ConfigMember<double> member;
  double least, most;  ///< both included
};
/// A number above zero, or none.
struct OptionalField {
  ConfigMember<std::optional<double>> member;
  double below = std::numeric_limits<double>::infinity();
  double most_parameter = 0.0;  ///< as a parameter, where 0 is none
};
struct ChoiceField {
  std::vector<std::string_view> names;
  std::size_t (*get)(const LiveConfig& config);  ///< of `names`
  void (*set)(LiveConfig& config, std::size_t choice);
  /// Where it may be other text besides: where that is (empty: one of `names` is chosen), and which it may
  /// be.
  std::optional<ConfigMember<std::string>> other = std::nullopt;
  bool (*may_be)(const std::string& text) = nullptr;

  /// Empty if it is none of `names`, nor other text.
  std::string_view chosen(const LiveConfig& config) const {
    if (other && !(*other)(config).empty()) return (*other)(config);
    const std::size_t choice = get(config);
    return choice < names.size() ? names[choice] : std::string_view();
  }
};
/// Several numbers that belong together.
struct NumbersField {
  std::size_t count;
  std::vector<double> (*get)(const LiveConfig& config);  ///< empty: not set
  void (*set)(LiveConfig& config,
              const std::vector<double>& all);  ///< \throws BadValue. \pre `count` of them
  bool shows_default = false;
  double most_parameter = 0.0;  ///< of each, on either side of zero
};
struct ToolField {
  ConfigMember<Tool> member;
};
using FieldType = std::variant<FlagField, TextField, CountField, NumberField, OptionalField, ChoiceField,
                               NumbersField, ToolField>;
/// @}

/// Besides what it is.
struct FieldTraits {
  bool saved = false;                   ///< one of the settings that a person works out and keeps
  bool read_only = false;               ///< as a parameter
  std::string_view excludes = {};       ///< name of the field that it replaces where it is set
  std::string_view shown_default = {};  ///< for people, where that is not the value
};

/// One field.
struct ConfigField {
  std::string_view name;       ///< key in TOML, long option of the command line; empty: has neither
  std::string_view parameter;  ///< in JSON, levels separated by dots; empty: is no parameter
  ConfigGroup group;
  std::string_view unit;  ///< or what stands for the value where that is no number
  std::string_view help;
  FieldType type;
  FieldTraits traits = {};
};

/// All of them but SceneConfig::path; in the order of their groups' members, as --help and files have them.
std::span<const ConfigField> config_fields();
/// The field of that name. \throws Error if there is none.
const ConfigField& config_field(std::string_view name);

/// Sets a field from text, numbers separated by commas. \throws BadValue, or Error for a tool's file.
void set_from_text(const ConfigField& field, LiveConfig& config, const std::string& text);
/// The default as people are shown it; empty: none.
std::string default_text(const ConfigField& field, const LiveConfig& config);

}  // namespace palpate
