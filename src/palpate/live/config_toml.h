/// \file
/// TOML configuration files of a live system: the keys of `palpate run --config`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <palpate/live/config_fields.h>
#include <palpate/live/live_config.h>

namespace palpate {

class TomlValue;

/// Selection of the fields that are written to a file.
enum class TomlFields : std::uint8_t {
  /// What the next run needs to have the same settings: those of scene (except its file), tool and force that
  /// a user tunes and keeps, and those of force, device and loop that differ from their defaults. A comment
  /// names what is left out.
  kSaved,
  kSavedOfHand,  ///< the same for one of several hands, which share the scene
  kAll,          ///< all named fields, including SceneConfig::path as `scene`
};

/// Returns the text of a file that reads back as `config`. Numbers round-trip exactly. False booleans and
/// unset fields are left out.
std::string to_toml(const LiveConfig& config, TomlFields fields);

/// One setting of a file: its key, and its value as TOML.
struct SettingText {
  std::string name, value;
};

/// Returns the settings of a group, as written by to_toml(); for the scene, includes SceneConfig::path as
/// `scene`.
std::vector<SettingText> settings_text(const LiveConfig& config, ConfigGroup group);

/// Returns `text` as a TOML basic string; invalid UTF-8 is replaced.
std::string toml_quoted(std::string_view text);

/// Converts a TOML value to the text that set_from_text() accepts: a scalar unchanged, an array's values
/// joined by commas.
/// \throws Error for anything else.
std::string value_text(const TomlValue& value);

/// An entry of a configuration file.
struct ConfigEntry {
  std::string key;    ///< long option name without dashes
  std::string value;  ///< as value_text() returns it
  std::string file;   ///< path of the file, for messages
  std::size_t line;   ///< from 1
};

/// Reads a TOML file whose keys are long option names (`opacity-min = 0.2`, `tool = [0.01, 0.01, 0.03]`,
/// `json = true`), of whatever command.
/// \throws Error with file and line if the file is not TOML or a value cannot be given on a command line
/// (tables, dates).
std::vector<ConfigEntry> read_config(const std::string& path);

/// Reads a configuration file on top of `defaults`. \throws Error with file and line if it is not TOML, has
/// an unknown key, a value that the field does not accept, or two mutually exclusive fields. \param
/// is_refused groups (kScene includes the key `scene`) that the file must not contain: those of the scene and
/// the gateway, which several hands share; null: none
LiveConfig read_live_config(const std::string& path, LiveConfig defaults = {},
                            bool (*is_refused)(ConfigGroup) = nullptr);

}  // namespace palpate
