/// \file
/// Configuration of a live system as a TOML file: the keys of `palpate run --config`.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/live/config_fields.h>
#include <palpate/live/live_config.h>

namespace palpate {

class TomlValue;

/// Which fields a file has.
enum class TomlFields : std::uint8_t {
  kSaved,        ///< the settings that a person works out and keeps: scene, tool and force
  kSavedOfHand,  ///< of them, those of one hand of several, which share the scene
  kAll,          ///< all that have a name, SceneConfig::path as `scene`, too
};

/// The text of a file that is read as `config`. Numbers read back exactly. Booleans that are false, and what
/// is not set, are left out.
std::string to_toml(const LiveConfig& config, TomlFields fields);

/// A setting as a file has it: its key, and its value as TOML.
struct SettingText {
  std::string name, value;
};

/// What is set of a group, as to_toml() has it; of the scene, SceneConfig::path as `scene`, too.
std::vector<SettingText> settings_text(const LiveConfig& config, ConfigGroup group);

/// As a basic string of TOML; what is no UTF-8 in it is replaced.
std::string toml_quoted(std::string_view text);

/// A value of TOML as set_from_text() takes it: a scalar as it is, an array's values joined by commas.
/// \throws Error for anything else.
std::string value_text(const TomlValue& value);

/// Reads such a file over `defaults`. \throws Error with file and line if it is not TOML, has a key that is
/// no field, a value that the field cannot take, or two fields that exclude each other. \param is_refused
/// groups, and with them `scene`, that the file may not have: those of a scene and a gateway that several
/// hands share; null: none
LiveConfig read_live_config(const std::string& path, LiveConfig defaults = {},
                            bool (*is_refused)(ConfigGroup) = nullptr);

}  // namespace palpate
